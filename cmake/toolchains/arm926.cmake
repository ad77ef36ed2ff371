# Debian's g++-arm-linux-gnueabi, restricted to the ARM926EJ-S: ARMv5, ARM state, no floating-point unit.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR arm926ej-s)
set(CMAKE_C_COMPILER arm-linux-gnueabi-gcc)
set(CMAKE_CXX_COMPILER arm-linux-gnueabi-g++)
set(rvdnav_arm926_flags "-mcpu=arm926ej-s -marm -mfloat-abi=soft")
set(CMAKE_C_FLAGS_INIT "${rvdnav_arm926_flags}")
# GCC notes on every call with 64-bit aligned arguments that the ABI changed in GCC 7; nothing here is that old.
set(CMAKE_CXX_FLAGS_INIT "${rvdnav_arm926_flags} -Wno-psabi")
# Static programs run under qemu-user without a copy of the target's libraries.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
