// SPDX-License-Identifier: Zlib
#include "atomic_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace limber::render {

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)),
      temporary_(path_ + ".part" + std::to_string(getpid())),
      file_(std::fopen(temporary_.c_str(), "wb")) {
  if (file_ == nullptr) {
    fail(errno);
  }
}

AtomicFile::~AtomicFile() {
  if (!named_) {
    file_.reset();
    std::remove(temporary_.c_str());
  }
}

void AtomicFile::write(const std::vector<std::uint8_t>& bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
    fail(errno);
  }
}

long AtomicFile::size() const { return std::ftell(file_.get()); }

void AtomicFile::overwrite(long offset, const std::vector<std::uint8_t>& bytes) {
  // Seeking writes what is still buffered, and that can fail as well.
  if (std::fseek(file_.get(), offset, SEEK_SET) != 0) {
    fail(errno);
  }
  write(bytes);
}

void AtomicFile::commit() {
  // So does closing.
  if (std::fclose(file_.release()) != 0 || std::rename(temporary_.c_str(), path_.c_str()) != 0) {
    fail(errno);
  }
  named_ = true;
}

void AtomicFile::fail(int error) const {
  throw std::runtime_error("cannot write " + path_ + ": " + std::strerror(error));
}

}  // namespace limber::render
