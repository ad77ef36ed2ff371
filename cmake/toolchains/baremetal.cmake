# Debian's gcc-arm-none-eabi without an operating system; the processor's own file sets rvdnav_processor_flags first.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_C_FLAGS_INIT "${rvdnav_processor_flags} -ffunction-sections -fdata-sections -fcallgraph-info=su")
# GCC notes on every call with 64-bit aligned arguments that the ABI changed in GCC 7; nothing here is that old.
set(CMAKE_CXX_FLAGS_INIT "${CMAKE_C_FLAGS_INIT} -Wno-psabi")
# A program needs a linker script: the compiler is tried without one.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
