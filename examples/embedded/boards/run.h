/* What the startup code calls. */
#ifndef BOARD_RUN_H
#define BOARD_RUN_H

enum { BOARD_FAULT_STATUS = 3 }; /* the program's status after a fault */

/* main, with the arguments that it was started with. */
_Noreturn void board_run(void);
/* What a processor's faults end in: unaligned accesses among them. */
_Noreturn void board_fault(void);

#endif
