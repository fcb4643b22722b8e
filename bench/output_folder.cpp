// SPDX-License-Identifier: Zlib
#include "output_folder.h"

#include "output_files.h"

#include <filesystem>
#include <system_error>

namespace limber::bench {

std::string prepareOutput(const std::string& folder, const std::string& fileName) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return "cannot use the folder " + folder + ": " + error.message();
  return demo::checkWritable(folder + "/" + fileName);
}

}  // namespace limber::bench
