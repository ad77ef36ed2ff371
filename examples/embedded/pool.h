/* All the memory there is, taken once at the start and never given back. */
#ifndef POOL_H
#define POOL_H

#include <stddef.h>

/* size bytes, aligned to 64; ends the program where they are not there. */
void* pool_take(size_t size);
size_t pool_used(void);
size_t pool_size(void);

#endif
