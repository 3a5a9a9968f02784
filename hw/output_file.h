// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "hw/descriptor.h"
#include "hw/wire_format.h"

namespace tactel::hw {

/// A file that grows while a sensor is read. Every failure, including that of the last byte, is thrown as
/// RecordingError with the name of the file. Writes in blocks of 8 KiB. A file that is not closed holds the
/// blocks written so far.
class OutputFile {
 public:
  enum class Existing { refuse, replace };
  /// Creates a new file. An existing regular file is rejected, or removed first; a symbolic link is rejected. A
  /// device or pipe is written to directly.
  explicit OutputFile(const std::filesystem::path& path, Existing existing = Existing::refuse);

  void write(Bytes bytes);
  void write(std::string_view text);
  void flush();                                 ///< passes all bytes to the system
  void close();                                 ///< flushes and waits until the file is on the disk
  std::uint64_t size() const { return size_; }  ///< bytes written so far

 private:
  void remove_file() const;
  [[noreturn]] void fail(const std::string& what, int error) const;
  std::filesystem::path path_;
  Descriptor descriptor_;
  std::uint64_t size_ = 0;
  std::string block_;
};

}  // namespace tactel::hw
