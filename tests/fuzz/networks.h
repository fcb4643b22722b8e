// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <string>

namespace limber::fuzz {

/// Returns the network of that name, built at the first call.
SharedNetwork networkNamed(const std::string& name);

}  // namespace limber::fuzz
