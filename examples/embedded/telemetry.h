/* Lines of text, made without a C library. */
#ifndef TELEMETRY_H
#define TELEMETRY_H

#include <stddef.h>
#include <stdint.h>

/* All append to the line; a newline writes it out. */
void put(const char* text);
void put_unsigned(uint64_t value);
void put_fixed(double value, int decimals);                     /* 0 to 9 of them; below 9e9 in size */
void put_vector(const double* values, int count, int decimals); /* each after a space */
void put_hash(uint64_t value);
void put_newline(void);

/* Ends the program with a line of what was wrong. */
_Noreturn void fail(const char* what, const char* why);

/* FNV-1a: http://www.isthe.com/chongo/tech/comp/fnv */
#define HASH_START UINT64_C(0xcbf29ce484222325)
uint64_t hash(uint64_t before, const void* data, size_t size);

#endif
