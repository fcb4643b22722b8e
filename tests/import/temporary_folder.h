// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

/// A new folder for one test, removed by the destructor.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string path() const { return path_; }

  /// Writes `content` to the file `name` in the folder and returns the path of the file.
  std::string write(const std::string& name, const std::string& content) const;

 private:
  std::string path_;
};
