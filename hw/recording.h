// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hw/descriptor.h"
#include "hw/frame_source.h"

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

inline constexpr std::string_view recording_magic = "tactel1\n";  ///< what a recording begins with

/// Writes the packets of a source (format: hw/README.md). Written packets stay readable after a crash of the
/// program. Every function throws RecordingError where the file cannot be written.
class RecordingWriter {
 public:
  /// description: a device profile, for a later replay.
  RecordingWriter(const std::filesystem::path& path, const std::string& description,
                  OutputFile::Existing existing = OutputFile::Existing::refuse);
  void write(const Packet& packet);
  /// Writes the end. Returns once the file is on the disk.
  void finish();

 private:
  OutputFile file_;
  std::vector<std::uint8_t> record_;
};

/// A recording, packet by packet.
class ReplaySource final : public FrameSource {
 public:
  /// real_time: returns the packets at their original pace; else as fast as they are read. Throws
  /// RecordingError.
  explicit ReplaySource(const std::filesystem::path& path, bool real_time = false);
  ~ReplaySource() override;

  const std::string& description() const;
  /// Returns true where the file ends without its last record: its writer was interrupted.
  bool cut_short() const override;

  /// Throws RecordingError at a damaged packet.
  std::optional<Packet> wait(double timeout) override;
  bool finished() const override;
  bool live() const override { return false; }
  double now() const override;  ///< arrival of the last packet plus the time since wait() returned it
  TransportCounts counts() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the CRC-32 of Ethernet and zip files.
std::uint32_t crc32(Bytes bytes);

}  // namespace tactel::hw
