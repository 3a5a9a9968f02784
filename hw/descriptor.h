// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace tactel::hw {

/// A file descriptor that closes itself, and leaves errno as it is.
class Descriptor {
 public:
  explicit Descriptor(int file = -1) : file_(file) {}
  Descriptor(Descriptor&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  Descriptor& operator=(Descriptor other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~Descriptor() {
    const int error = errno;
    close();
    errno = error;
  }
  /// Returns false on failure, with errno; the descriptor is gone then, too.
  bool close() { return file_ < 0 || ::close(std::exchange(file_, -1)) == 0; }
  operator int() const { return file_; }  ///< -1: none

 private:
  int file_;
};

}  // namespace tactel::hw
