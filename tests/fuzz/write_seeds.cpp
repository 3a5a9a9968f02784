// SPDX-License-Identifier: Apache-2.0

// Whole files for the fuzz targets to start from, which no random bytes would hit past a checksum:
// fuzz_seeds DIR writes DIR/TARGET/seed*.
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>

#include "host/networks/onnx_file.h"
#include "hw/recording.h"
#include "nn/weights.h"
#include "tests/fuzz/checkpoint_records.h"
#include "tests/fuzz/counted_layout.h"
#include "tests/fuzz/small_spool.h"
#include "tests/hw/byte_vectors.h"

namespace tactel::fuzz {
namespace {

namespace fs = std::filesystem;
using hw::tests::append;
using hw::tests::ByteVector;

/// DIR/TARGET/name, in a folder that is there.
fs::path seed(const fs::path& corpus, const std::string& target, const std::string& name = "seed") {
  fs::create_directories(corpus / target);
  return corpus / target / name;
}

void write(const fs::path& path, const ByteVector& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

ByteVector generic_frame(int i) {
  const hw::GenericLayout layout = hw::counted_layout();
  const double samples[] = {1, 2, 3, 4};
  ByteVector frame(hw::generic_frame_length(layout));
  write_generic_frame(layout, static_cast<std::uint64_t>(i), 100 * static_cast<std::uint64_t>(i), samples, frame);
  return frame;
}

/// As many frames as the format wants in a row, and more. The first byte says how the stream is split
/// (fuzz_format.cpp): parts of 64 bytes.
void write_stream(const fs::path& path, int frames, const std::function<ByteVector(int)>& frame) {
  ByteVector stream = {2};
  for (int i = 0; i < frames; ++i) append(stream, frame(i));
  write(path, stream);
}

void write_streams(const fs::path& corpus) {
  using namespace hw::tests;
  write_stream(seed(corpus, "decode_glove"), 2, glove_frame);
  write_stream(seed(corpus, "decode_papillarray"), 2, [](int i) {
    return papillarray_frame({.sensors = 2, .counter = static_cast<std::uint32_t>(i), .undocumented = i == 1});
  });
  write_stream(seed(corpus, "decode_anyskin"), 5, [](int i) { return anyskin_frame(static_cast<float>(i)); });
  write_stream(seed(corpus, "decode_agni"), 2, agni_frame);
  write_stream(seed(corpus, "decode_paxini"), 3, [](int i) { return paxini_frame(static_cast<std::uint8_t>(i)); });
  write_stream(seed(corpus, "decode_generic"), 3, generic_frame);
}

/// The profile of counted_layout().
constexpr const char* generic_profile =
    "[device]\nname = \"counted\"\n[format]\nkind = \"generic\"\nsync = [0xA5, 0x5A]\nheader = 8\ncounter_offset = 2\n"
    "counter_width = 2\nclock_offset = 4\nclock_width = 4\nchannels = 4\nchecksum = \"crc16\"\ntrailer = [0x0D]\n"
    "confirmations = 2\n[channels]\nnormal = [0, 1]\nshear = [2, 3]\n[calibration]\noffset = 1.0\ngain = 0.001\n";

void write_recording(const fs::path& path, bool finished) {
  hw::RecordingWriter writer(path, generic_profile, hw::OutputFile::Existing::replace);
  for (int i = 0; i < 3; ++i) {
    const ByteVector frame = generic_frame(i);
    writer.write({.bytes = frame, .arrival = 0.01 * i, .after_gap = i == 2});
  }
  if (finished) writer.finish();
}

void write_network(const fs::path& path, const char* topology, nn::ScalingKind scaling) {
  nn::Model model{nn::initial_weights(nn::Topology::parse(topology), 3), {scaling, 2.0f}, 3, 0.1, "set.h5", 20, {}};
  host::write_onnx(path, model);
}

void write_checkpoint(const fs::path& path) {
  const auto records = checkpoint_records();
  host::write_checkpoint<float>(path, checkpoint_plan, records);
}

/// Chunks 0 and 1 of an unfinished set.
void write_spool(const fs::path& path) {
  const fs::path output = path.parent_path() / "set.h5";
  write_small_spool(output);
  fs::copy_file(host::SetSpool::folder(output) / "0000.chunks", path, fs::copy_options::overwrite_existing);
  host::SetSpool::discard(output);
}

}  // namespace
}  // namespace tactel::fuzz

int main(int count, char** arguments) {
  using namespace tactel;
  using namespace tactel::fuzz;
  if (count != 2) {
    std::cerr << "fuzz_seeds DIR\n";
    return 2;
  }
  const fs::path corpus = arguments[1];
  write_streams(corpus);
  write(seed(corpus, "sensor_profile"), {generic_profile, generic_profile + std::strlen(generic_profile)});
  write_recording(seed(corpus, "recording"), true);
  write_recording(seed(corpus, "recording", "seed_cut_off"), false);
  write_network(seed(corpus, "network"), "4-3-1", nn::ScalingKind::set);
  write_network(seed(corpus, "network", "seed_by_frame"), "2-2-2-1", nn::ScalingKind::frame);
  write_network(seed(corpus, "network", "seed_leaky"), "4-3-1_leaky-relu", nn::ScalingKind::frame);
  write_checkpoint(seed(corpus, "checkpoint"));
  host::write_contact_set(seed(corpus, "set_file"), small_set());
  write_spool(seed(corpus, "spool"));
}
