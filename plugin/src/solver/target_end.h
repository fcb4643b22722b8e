// SPDX-License-Identifier: Zlib
// Ends the settings of target_begin.h. GCC's pragmas last until the end of the source file.

#if defined(__clang__) && !defined(__aarch64__)
#pragma clang attribute pop
#endif
