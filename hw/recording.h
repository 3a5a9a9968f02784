#pragma once
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "hw/frame_source.h"

namespace tactel::hw {

/// Writes the packets of a source as they came (format: hw/README.md). What was written stays readable when the
/// program dies.
class RecordingWriter {
 public:
  /// description: how to read the bytes, for whoever replays them (a device profile). Throws RecordingError.
  RecordingWriter(const std::filesystem::path& path, const std::string& description);
  /// frames: how many were decoded before this packet, for the index.
  void write(const Packet& packet, std::uint64_t frames);
  /// Writes the index. Throws RecordingError when the file is not whole on the disk.
  void finish();

 private:
  void put(const std::vector<std::uint8_t>& bytes);
  void check() const;
  std::filesystem::path path_;
  std::ofstream file_;
  std::uint64_t at_ = 0, packets_ = 0;
  std::vector<std::uint8_t> index_, scratch_;
};

/// A recording, packet by packet.
class ReplaySource final : public FrameSource {
 public:
  /// real_time: hand the packets out at the pace they came; else as fast as they are taken. Throws RecordingError.
  explicit ReplaySource(const std::filesystem::path& path, bool real_time = false);
  ~ReplaySource() override;

  const std::string& description() const;
  /// The file ends without its index: whoever recorded it was cut off. Known once finished.
  bool cut_short() const;

  /// Throws RecordingError at a damaged packet.
  std::optional<Packet> wait(double timeout) override;
  bool finished() const override;
  bool live() const override { return false; }
  double now() const override;  ///< goes on from the arrival of the last packet since it was handed out
  TransportCounts counts() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// CRC-32 as in Ethernet and zip files.
std::uint32_t crc32(Bytes bytes);

}  // namespace tactel::hw
