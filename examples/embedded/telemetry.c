#include "telemetry.h"

#include "board.h"

static char line[1024];
static size_t length;

static void put_char(char c) {
  if (length < sizeof line) line[length++] = c;
}

void put(const char* text) {
  for (; *text != '\0'; ++text) put_char(*text);
}

static void put_digits(uint64_t value, unsigned base, int least) {
  char digits[20];
  int n = 0;
  do {
    digits[n++] = "0123456789abcdef"[value % base];
    value /= base;
  } while (value != 0 || n < least);
  while (n > 0) put_char(digits[--n]);
}

void put_unsigned(uint64_t value) { put_digits(value, 10, 1); }

void put_fixed(double value, int decimals) {
  uint64_t unit = 1;
  for (int i = 0; i < decimals; ++i) unit *= 10;
  if (value < 0.0) put_char('-');
  const uint64_t scaled = (uint64_t)((value < 0.0 ? -value : value) * (double)unit + 0.5);
  put_unsigned(scaled / unit);
  if (decimals == 0) return;
  put_char('.');
  put_digits(scaled % unit, 10, decimals);
}

void put_vector(const double* values, int count, int decimals) {
  for (int i = 0; i < count; ++i) {
    put(" ");
    put_fixed(values[i], decimals);
  }
}

void put_hash(uint64_t value) { put_digits(value, 16, 16); }

void put_newline(void) {
  put_char('\n');
  board_write(line, length);
  length = 0;
}

void fail(const char* what, const char* why) {
  put("failed: ");
  put(what);
  put(": ");
  put(why);
  put_newline();
  board_exit(2);
}

uint64_t hash(uint64_t before, const void* data, size_t size) {
  const unsigned char* bytes = data;
  for (size_t i = 0; i < size; ++i) before = (before ^ bytes[i]) * UINT64_C(0x100000001b3);
  return before;
}
