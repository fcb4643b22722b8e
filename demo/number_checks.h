// SPDX-License-Identifier: Zlib
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

namespace limber::demo {

/// Returns the number that the whole text is, if it is a finite one.
std::optional<double> finiteNumber(const std::string& text);

/// Accepts finite numbers from `low` to `high`. (CLI::Range accepts "nan".)
CLI::Validator number(double low, double high);

/// Accepts digits only, from `low` to `high`.
CLI::Validator wholeNumber(double low, double high);

/// Accepts WIDTHxHEIGHT of 16 to 8192 pixels each.
CLI::Validator pictureSize();

/// False if `text` is not of the form WIDTHxHEIGHT, with at most 6 digits each.
bool parseSize(const std::string& text, int& width, int& height);

}  // namespace limber::demo
