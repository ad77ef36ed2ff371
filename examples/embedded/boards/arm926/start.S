@ From reset to board_run on an ARM926EJ-S, in QEMU's versatilepb: vectors, a stack, alignment checks, zeroed data.

  .syntax unified
  .arm

  .section .vectors, "ax"
vectors:
  b start
  b fault                        @ undefined instruction
  b fault                        @ supervisor call: semihosting's never come here
  b fault                        @ prefetch abort
  b fault                        @ data abort
  b fault
  b fault
  b fault

  .section .text.start, "ax"
  .global start
start:
  ldr sp, =stack_top
  mrc p15, 0, r0, c1, c0, 0
  orr r0, r0, #2                 @ SCTLR.A: an unaligned access aborts
  mcr p15, 0, r0, c1, c0, 0
  ldr r0, =bss_start
  ldr r1, =bss_end
  mov r2, #0
1:
  cmp r0, r1
  strlo r2, [r0], #4
  blo 1b
  b board_run

fault:                           @ the modes' own stack pointers were never set
  msr cpsr_c, #0xd3
  ldr sp, =stack_top
  b board_fault
