#include "program.h"

#include <string.h>

#include "board.h"
#include "pool.h"
#include "telemetry.h"

void check(rvdnav_status status, const char* call) {
  if (status != RVDNAV_OK) fail(call, rvdnav_status_text(status));
}

static int32_t isa_named(const char* name) {
  if (strcmp(name, "scalar") == 0) return RVDNAV_ISA_SCALAR;
  if (strcmp(name, "sse2") == 0) return RVDNAV_ISA_SSE2;
  if (strcmp(name, "avx2") == 0) return RVDNAV_ISA_AVX2;
  if (strcmp(name, "neon") == 0) return RVDNAV_ISA_NEON;
  fail(name, "no such instruction set");
}

rvdnav_context* program_start(int argc, char** argv, Sequence* sequence) {
  if (argc < 2) fail("usage", "SEQUENCE [scalar|sse2|avx2|neon]");
  sequence_open(argv[1], sequence);
  rvdnav_config* config = &sequence->config;
  config->isa = argc > 2 ? isa_named(argv[2]) : RVDNAV_ISA_AUTO;
  size_t size = 0;
  check(rvdnav_context_size(config, &sequence->rig, &size), "rvdnav_context_size");
  rvdnav_context* context = NULL;
  check(rvdnav_context_init(pool_take(size), size, config, &sequence->rig, &sequence->target, &context),
        "rvdnav_context_init");
  check(rvdnav_context_config(context, config), "rvdnav_context_config");
  return context;
}

void put_memory(void) {
  put("memory pool ");
  put_unsigned(pool_used());
  put(" of ");
  put_unsigned(pool_size());
  if (board_stack_size() > 0) {
    put(" stack ");
    put_unsigned(board_stack_used());
    put(" of ");
    put_unsigned(board_stack_size());
  }
  put_newline();
}
