/* What the programs need of the machine they run on: a file to read, a line to write to, a way to end.
 *
 * board_linux.c does it with the C library, board_semihosting.c with a debugger's or an emulator's semihosting.  On a
 * flight computer the images come from the cameras and the lines go to the telemetry. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>

bool board_open(const char* path);
/* Reads the next size bytes of the open file; false if there are fewer. */
bool board_read(void* data, size_t size);
void board_write(const char* text, size_t length);
_Noreturn void board_exit(int status);

/* Bytes of the deepest stack so far, of how many there are; 0 where nobody keeps count. */
size_t board_stack_used(void);
size_t board_stack_size(void);

#endif
