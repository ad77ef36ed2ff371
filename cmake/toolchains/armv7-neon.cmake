# Debian's g++-arm-linux-gnueabihf for the Cortex-A7 and later: ARMv7, Thumb, NEON for integers, VFPv4 for doubles.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR armv7)
set(CMAKE_C_COMPILER arm-linux-gnueabihf-gcc)
set(CMAKE_CXX_COMPILER arm-linux-gnueabihf-g++)
set(rvdnav_armv7_flags "-mcpu=cortex-a7 -mfpu=neon-vfpv4 -mfloat-abi=hard")
set(CMAKE_C_FLAGS_INIT "${rvdnav_armv7_flags}")
# GCC notes on every call with 64-bit aligned arguments that the ABI changed in GCC 7; nothing here is that old.
set(CMAKE_CXX_FLAGS_INIT "${rvdnav_armv7_flags} -Wno-psabi")
# Static programs run under qemu-user without a copy of the target's libraries.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
