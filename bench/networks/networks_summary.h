// SPDX-License-Identifier: Zlib
#pragma once

#include "networks/counts_table.h"
#include "networks/large_table.h"
#include "networks/mass_table.h"
#include "networks/material_table.h"
#include "networks/models_table.h"
#include "networks/network_row.h"
#include "networks/skin_table.h"

namespace limber::bench {

struct NetworkResults {
  std::vector<CountRow> counts;
  std::vector<NetworkRow> networks;
  std::vector<MassRow> masses;
  std::vector<SkinRow> skins;
  std::vector<LargeRow> large;
  std::vector<ModelRow> models;
  MaterialResults materials;
};

/// The tables, and which targets are hit.
std::string summariseNetworks(const NetworkResults& results);

}  // namespace limber::bench
