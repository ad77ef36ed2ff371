/* The board without an operating system: Arm semihosting ("Semihosting for AArch32 and AArch64", Arm 2023) for files
 * and text, and a stack that was painted before it was used.  The startup code calls board_run. */
#include <stdint.h>

#include "board.h"
#include "boards/run.h"

enum { SYS_OPEN = 0x01, SYS_WRITE = 0x05, SYS_READ = 0x06, SYS_GET_CMDLINE = 0x15, SYS_EXIT_EXTENDED = 0x20 };
enum { MODE_READ_BINARY = 1, MODE_WRITE_BINARY = 5 };
enum { STOPPED_APPLICATION_EXIT = 0x20026 };
enum { MAX_ARGUMENTS = 8 };

static const uint32_t PAINT = 0xa5a5a5a5U;

/* From the linker script. */
extern uint32_t stack_bottom[], stack_top[];

int main(int argc, char** argv);

static char command_line[256];
static intptr_t console;
static intptr_t sequence;

static intptr_t semihosting(int operation, const void* block) {
  register intptr_t r0 __asm__("r0") = operation;
  register const void* r1 __asm__("r1") = block;
#if defined(__thumb__)
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
#else
  __asm__ volatile("svc 0x123456" : "+r"(r0) : "r"(r1) : "memory", "lr");
#endif
  return r0;
}

static intptr_t open_file(const char* path, size_t length, intptr_t mode) {
  const intptr_t block[3] = {(intptr_t)path, mode, (intptr_t)length};
  return semihosting(SYS_OPEN, block);
}

static size_t length_of(const char* text) {
  size_t n = 0;
  while (text[n] != '\0') ++n;
  return n;
}

bool board_open(const char* path) {
  sequence = open_file(path, length_of(path), MODE_READ_BINARY);
  return sequence >= 0;
}

bool board_read(void* data, size_t size) {
  const intptr_t block[3] = {sequence, (intptr_t)data, (intptr_t)size};
  return semihosting(SYS_READ, block) == 0; /* the answer is how much is missing */
}

void board_write(const char* text, size_t length) {
  const intptr_t block[3] = {console, (intptr_t)text, (intptr_t)length};
  (void)semihosting(SYS_WRITE, block);
}

void board_exit(int status) {
  const intptr_t block[2] = {STOPPED_APPLICATION_EXIT, status};
  (void)semihosting(SYS_EXIT_EXTENDED, block);
  for (;;) {
  }
}

void board_fault(void) {
  static const char text[] = "fault\n";
  board_write(text, sizeof text - 1);
  board_exit(BOARD_FAULT_STATUS);
}

size_t board_stack_size(void) { return (size_t)(stack_top - stack_bottom) * sizeof *stack_bottom; }

size_t board_stack_used(void) {
  const uint32_t* deepest = stack_bottom;
  while (deepest < stack_top && *deepest == PAINT) ++deepest;
  return (size_t)(stack_top - deepest) * sizeof *deepest;
}

/* Everything below this function's own frame. */
static void paint_stack(void) {
  uint32_t* const own = __builtin_frame_address(0);
  for (volatile uint32_t* p = stack_bottom; p < own - 64; ++p) *p = PAINT;
}

static int split_arguments(char** argv) {
  const intptr_t block[2] = {(intptr_t)command_line, sizeof command_line};
  if (semihosting(SYS_GET_CMDLINE, block) != 0) return 0;
  int argc = 0;
  for (char* p = command_line; *p != '\0' && argc < MAX_ARGUMENTS;) {
    argv[argc++] = p;
    while (*p != '\0' && *p != ' ') ++p;
    while (*p == ' ') *p++ = '\0';
  }
  return argc;
}

void board_run(void) {
  char* argv[MAX_ARGUMENTS];
  paint_stack();
  console = open_file(":tt", 3, MODE_WRITE_BINARY);
  board_exit(main(split_arguments(argv), argv));
}
