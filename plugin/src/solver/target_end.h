// SPDX-License-Identifier: Zlib
// Ends what target_begin.h began; GCC's pragmas last to the end of the source.

#if defined(__clang__)
#pragma clang attribute pop
#endif
