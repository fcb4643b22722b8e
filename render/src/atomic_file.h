// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace limber::render {

/// A file that is seen whole or not at all: written under a temporary name beside `path`, renamed by
/// commit(), removed if it does not come to that. Errors are std::runtime_error naming the path and
/// the reason; after one, only the destructor is of use.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends.
  void write(const std::vector<std::uint8_t>& bytes);
  /// Bytes written so far.
  long size() const;
  /// Replaces bytes from an offset on; nothing can be appended afterwards.
  void overwrite(long offset, const std::vector<std::uint8_t>& bytes);
  /// Ends the file and gives it its name.
  void commit();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void fail(int error) const;

  std::string path_;
  std::string temporary_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  bool named_ = false;
};

}  // namespace limber::render
