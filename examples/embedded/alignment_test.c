/* Reads a word from an odd address: on a processor that is set up to trap that, the program ends in a fault. */
#include <stdint.h>

int main(void) {
  static const uint32_t words[2] = {0, 0};
  /* Volatile, or the compiler would see the misalignment and read bytes. */
  volatile uintptr_t address = (uintptr_t)words + 1;
  (void)*(const volatile uint32_t*)address;
  return 0;
}
