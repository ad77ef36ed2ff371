# The ARM926EJ-S: ARMv5, ARM state, no floating-point unit.
set(CMAKE_SYSTEM_PROCESSOR arm926ej-s)
set(rvdnav_processor_flags "-mcpu=arm926ej-s -marm -mfloat-abi=soft")
include("${CMAKE_CURRENT_LIST_DIR}/baremetal.cmake")
