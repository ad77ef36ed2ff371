/* How both programs begin and end. */
#ifndef PROGRAM_H
#define PROGRAM_H

#include "rvdnav/rvdnav.h"
#include "sequence.h"

/* Ends the program where a call failed. */
void check(rvdnav_status status, const char* call);

/* Opens argv[1], and makes the context for its rig and target with the instruction set that argv[2] names, or the best
 * there is.  Fills in the settings in use. */
rvdnav_context* program_start(int argc, char** argv, Sequence* sequence);

/* A line with the bytes taken of the pool and, where the board keeps count, of the stack. */
void put_memory(void);

#endif
