/* From reset to board_run on a Cortex-M7, in QEMU's mps2-an500: vectors, floating point, alignment checks, data. */
#include <stdint.h>

#include "../run.h"

extern uint32_t stack_top[], data_load[], data_start[], data_end[], bss_start[], bss_end[];

/* ARMv7-M Architecture Reference Manual, B3.2. */
static volatile uint32_t* const CCR = (volatile uint32_t*)0xe000ed14U;
static volatile uint32_t* const CPACR = (volatile uint32_t*)0xe000ed88U;
enum { CCR_UNALIGN_TRP = 1 << 3, CPACR_FULL_CP10_CP11 = 0xf << 20 };

_Noreturn void start(void);

/* The stack, reset, and the system's faults; no interrupt is ever enabled. */
__attribute__((section(".vectors"), used)) static void* const vectors[] = {
    stack_top,          (void*)start,       (void*)board_fault, (void*)board_fault,
    (void*)board_fault, (void*)board_fault, (void*)board_fault,
};

void start(void) {
  *CPACR |= CPACR_FULL_CP10_CP11;
  *CCR |= CCR_UNALIGN_TRP; /* an unaligned access is a usage fault */
  __asm__ volatile("dsb\n\tisb");
  const uint32_t* from = data_load;
  for (volatile uint32_t* to = data_start; to < data_end; ++to) *to = *from++;
  for (volatile uint32_t* to = bss_start; to < bss_end; ++to) *to = 0;
  board_run();
}
