#include "pool.h"

#include "telemetry.h"

enum {
  ALIGNMENT = 64,
  POOL_SIZE = 10 << 20 /* two views of 704 x 576 pixels take 6 MiB, all outputs of their stages the rest */
};

/* A linker script may put it where the memory is large. */
static unsigned char block[POOL_SIZE] __attribute__((section(".bss.pool"), aligned(ALIGNMENT)));
static size_t used;

void* pool_take(size_t size) {
  const size_t rounded = (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
  if (rounded < size || rounded > sizeof block - used) fail("memory", "the pool is too small");
  void* const taken = block + used;
  used += rounded;
  return taken;
}

size_t pool_used(void) { return used; }
size_t pool_size(void) { return sizeof block; }
