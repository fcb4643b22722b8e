// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace limber::bench {

/// As printf, up to 300 characters.
[[gnu::format(printf, 1, 2)]] inline std::string format(const char* pattern, ...) {
  char text[300];
  va_list values;
  va_start(values, pattern);
  std::vsnprintf(text, sizeof text, pattern, values);
  va_end(values);
  return text;
}

}  // namespace limber::bench
