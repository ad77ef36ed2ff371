# The Cortex-M7 with its floating-point unit for doubles.
set(CMAKE_SYSTEM_PROCESSOR cortex-m7)
set(rvdnav_processor_flags "-mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard")
include("${CMAKE_CURRENT_LIST_DIR}/baremetal.cmake")
