// SPDX-License-Identifier: Zlib
#include "number_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace limber::demo {
namespace {

constexpr int kMinPicture = 16;
constexpr int kMaxPicture = 8192;

bool allDigits(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

std::string rangeError(const std::string& text, double low, double high) {
  char line[120];
  std::snprintf(line, sizeof line, " is not between %g and %g", low, high);
  return text + line;
}

std::string checkNumber(const std::string& text, double low, double high) {
  const std::optional<double> value = finiteNumber(text);
  if (!value) return text + " is not a finite number";
  return *value >= low && *value <= high ? std::string() : rangeError(text, low, high);
}

std::string checkSize(const std::string& text) {
  int width = 0, height = 0;
  if (!parseSize(text, width, height)) return text + " is not of the form WIDTHxHEIGHT, as in 960x540";
  const auto [smaller, larger] = std::minmax(width, height);
  return smaller >= kMinPicture && larger <= kMaxPicture
             ? std::string()
             : rangeError(text, kMinPicture, kMaxPicture) + " pixels";
}

}  // namespace

std::optional<double> finiteNumber(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

CLI::Validator number(double low, double high) {
  return CLI::Validator([=](std::string& text) { return checkNumber(text, low, high); }, "NUMBER");
}

CLI::Validator wholeNumber(double low, double high) {
  const auto check = [=](std::string& text) {
    if (!allDigits(text)) return text + " is not a whole number";
    // CLI11 reads such numbers as octal ones
    if (text.size() > 1 && text[0] == '0') return text + " begins with a zero";
    return checkNumber(text, low, high);
  };
  return CLI::Validator(check, "WHOLE");
}

CLI::Validator pictureSize() {
  return CLI::Validator([](std::string& text) { return checkSize(text); }, "WxH");
}

bool parseSize(const std::string& text, int& width, int& height) {
  const std::size_t x = text.find('x');
  if (x == std::string::npos) return false;
  const std::string first = text.substr(0, x);
  const std::string second = text.substr(x + 1);
  if (!allDigits(first) || !allDigits(second) || first.size() > 6 || second.size() > 6) return false;
  width = std::atoi(first.c_str());
  height = std::atoi(second.c_str());
  return true;
}

}  // namespace limber::demo
