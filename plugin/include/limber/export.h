// SPDX-License-Identifier: Zlib
#pragma once

// LIMBER_API marks what the libraries offer: in a shared library everything else is hidden. LIMBER_IMPORT_API
// is the same for limber::import. Without LIMBER_SHARED, for static libraries and sources of your project,
// they are empty. LIMBER_SHARED comes with the CMake targets and the .pc files. LIMBER_EXPORTS and
// LIMBER_IMPORT_EXPORTS are defined while Limber itself is compiled.

#if !defined(LIMBER_SHARED)
#define LIMBER_API
#define LIMBER_IMPORT_API
#elif !defined(_WIN32)
#define LIMBER_API __attribute__((visibility("default")))
#define LIMBER_IMPORT_API __attribute__((visibility("default")))
#else
#if defined(LIMBER_EXPORTS)
#define LIMBER_API __declspec(dllexport)
#else
#define LIMBER_API __declspec(dllimport)
#endif
#if defined(LIMBER_IMPORT_EXPORTS)
#define LIMBER_IMPORT_API __declspec(dllexport)
#else
#define LIMBER_IMPORT_API __declspec(dllimport)
#endif
#endif
