// SPDX-License-Identifier: Zlib
#pragma once

// LIMBER_HIDDEN keeps a private type that is nested in an exported class out of what a shared library offers.
#if defined(__GNUC__) && !defined(_WIN32)
#define LIMBER_HIDDEN __attribute__((visibility("hidden")))
#else
#define LIMBER_HIDDEN
#endif
