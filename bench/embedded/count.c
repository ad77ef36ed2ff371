/* A QEMU plugin that counts instructions between marks.
 *
 * -plugin libcount.so,marks=FILE,out=FILE
 *
 * marks: lines of an address in hexadecimal digits and a name.  out: for every time that the instruction at a mark's
 * address was reached, a line of its name and how many instructions had run before.  A conditional instruction counts
 * whether its condition holds or not. */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What is needed of QEMU's interface for plugins, version 1 (its header is not in Debian's packages). */
typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef struct qemu_info_t qemu_info_t;
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS };
enum qemu_plugin_op { QEMU_PLUGIN_INLINE_ADD_U64 };
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id,
                                           void (*translated)(qemu_plugin_id_t id, struct qemu_plugin_tb* block));
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn* instruction,
                                            void (*executed)(unsigned processor, void* user),
                                            enum qemu_plugin_cb_flags flags, void* user);
void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn* instruction, enum qemu_plugin_op op,
                                                void* counter, uint64_t step);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, void (*ended)(qemu_plugin_id_t id, void* user), void* user);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* block, size_t index);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn* instruction);

#define EXPORT __attribute__((visibility("default")))

EXPORT int qemu_plugin_version = 1;
EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc, char** argv);

enum { MAX_MARKS = 256 };

typedef struct Mark {
  uint64_t address;
  char name[64];
} Mark;

static Mark marks[MAX_MARKS];
static size_t mark_count;
static uint64_t instructions;
static FILE* out;

static void reach_mark(unsigned processor, void* user) {
  (void)processor;
  const Mark* mark = user;
  fprintf(out, "%s %" PRIu64 "\n", mark->name, instructions);
}

static void add_counters(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  const size_t n = qemu_plugin_tb_n_insns(block);
  for (size_t i = 0; i < n; ++i) {
    struct qemu_plugin_insn* instruction = qemu_plugin_tb_get_insn(block, i);
    const uint64_t address = qemu_plugin_insn_vaddr(instruction);
    for (size_t k = 0; k < mark_count; ++k) {
      if (marks[k].address != address) continue;
      qemu_plugin_register_vcpu_insn_exec_cb(instruction, reach_mark, QEMU_PLUGIN_CB_NO_REGS, &marks[k]);
    }
    qemu_plugin_register_vcpu_insn_exec_inline(instruction, QEMU_PLUGIN_INLINE_ADD_U64, &instructions, 1);
  }
}

static void close_out(qemu_plugin_id_t id, void* user) {
  (void)id;
  (void)user;
  fprintf(out, "end %" PRIu64 "\n", instructions);
  fclose(out);
}

static bool read_marks(const char* path) {
  FILE* file = fopen(path, "r");
  if (file == NULL) return false;
  while (mark_count < MAX_MARKS &&
         fscanf(file, "%" SCNx64 " %63s", &marks[mark_count].address, marks[mark_count].name) == 2) {
    ++mark_count;
  }
  const bool complete = feof(file) != 0;
  fclose(file);
  return complete;
}

static const char* value_of(int argc, char** argv, const char* key) {
  const size_t length = strlen(key);
  for (int i = 0; i < argc; ++i) {
    if (strncmp(argv[i], key, length) == 0 && argv[i][length] == '=') return argv[i] + length + 1;
  }
  return "";
}

int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc, char** argv) {
  (void)info;
  out = fopen(value_of(argc, argv, "out"), "w");
  if (out == NULL || !read_marks(value_of(argc, argv, "marks"))) return -1;
  qemu_plugin_register_vcpu_tb_trans_cb(id, add_counters);
  qemu_plugin_register_atexit_cb(id, close_out, NULL);
  return 0;
}
