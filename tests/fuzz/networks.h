// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <string>

namespace limber::fuzz {

/// The network of that name, cooked when it is first asked for.
SharedNetwork networkNamed(const std::string& name);

}  // namespace limber::fuzz
