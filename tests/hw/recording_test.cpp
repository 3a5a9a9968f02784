#include "hw/recording.h"

#include <gmock/gmock.h>

#include <cstdlib>

#include "hw/formats.h"
#include "tests/hw/byte_vectors.h"

namespace tactel::hw::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class Recording : public ::testing::Test {
 protected:
  Recording() {
    std::string folder = (fs::temp_directory_path() / "tactel-recording-XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) throw std::runtime_error("no folder " + folder);
    path_ = fs::path(folder) / "glove.tactel";
  }
  ~Recording() override { fs::remove_all(path_.parent_path()); }

  /// 600 packets of 17 bytes at odd times, a gap before packet 100.
  void record() const {
    RecordingWriter writer(path_, "[device]\nformat = \"glove\"\n");
    for (std::size_t i = 0; i < packets; ++i)
      writer.write({Bytes(stream_).subspan(17 * i, 17), 0.1 * static_cast<double>(i), i == 100}, i / 19);
    writer.finish();
  }
  static ByteVector glove_stream() {
    ByteVector stream;
    for (int i = 0; i < 32; ++i) append(stream, glove_frame(11 * i));
    return stream;
  }
  void damage(std::streamoff at) const {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(at);
    const int byte = file.get();
    file.seekp(at);
    file.put(static_cast<char>(byte ^ 1));
  }
  static constexpr std::size_t packets = 600;
  fs::path path_;
  ByteVector stream_ = glove_stream();
};

TEST_F(Recording, GivesBackEveryPacketBitForBit) {
  record();
  ReplaySource source(path_);
  EXPECT_EQ(source.description(), "[device]\nformat = \"glove\"\n");
  for (std::size_t i = 0; i < packets; ++i) {
    const auto packet = source.wait(0);
    ASSERT_TRUE(packet);
    ASSERT_EQ(
        ByteVector(packet->bytes.begin(), packet->bytes.end()),
        ByteVector(stream_.begin() + static_cast<long>(17 * i), stream_.begin() + static_cast<long>(17 * i + 17)));
    ASSERT_EQ(packet->arrival, 0.1 * static_cast<double>(i));
    ASSERT_EQ(packet->after_gap, i == 100);
  }
  EXPECT_FALSE(source.wait(0));
  EXPECT_TRUE(source.finished());
  EXPECT_FALSE(source.cut_short());
  EXPECT_EQ(source.counts().bytes, 17 * packets);
}

TEST_F(Recording, IsReadableUpToWhereItWasCutOff) {
  record();
  fs::resize_file(path_, fs::file_size(path_) / 2);
  ReplaySource source(path_);
  std::size_t count = 0;
  while (source.wait(0)) ++count;
  EXPECT_GT(count, packets / 3);
  EXPECT_LT(count, packets);
  EXPECT_TRUE(source.cut_short());
}

TEST_F(Recording, DamageIsFound) {
  record();
  damage(5000);
  ReplaySource source(path_);
  EXPECT_THAT(
      [&] {
        while (source.wait(0))
          ;
      },
      ThrowsMessage<SourceError>(HasSubstr("damaged")));
}

TEST_F(Recording, OtherFilesAreRefused) {
  std::ofstream(path_) << "frame,normal,shear\n1,2,3\n";
  EXPECT_THAT([&] { ReplaySource{path_}; }, ThrowsMessage<SourceError>(HasSubstr("no recording")));
  EXPECT_THAT([&] { ReplaySource{path_.parent_path() / "none"}; },
              ThrowsMessage<SourceError>(HasSubstr("cannot be read")));
  EXPECT_THROW(RecordingWriter("/no/such/folder/file", ""), SourceError);
}

TEST_F(Recording, PlaysInRealTimeWhenAsked) {
  RecordingWriter writer(path_, "");
  writer.write({Bytes(stream_).first(4), 5.0}, 0);
  writer.write({Bytes(stream_).first(4), 5.05}, 0);
  writer.finish();
  ReplaySource source(path_, true);
  EXPECT_TRUE(source.wait(1));
  EXPECT_FALSE(source.wait(0)) << "the second comes 50 ms after the first";
  EXPECT_FALSE(source.finished());
  EXPECT_TRUE(source.wait(1));
}

TEST(Crc32, CatalogueValue) {
  EXPECT_EQ(crc32(Bytes(reinterpret_cast<const std::uint8_t*>("123456789"), 9)), 0xCBF43926u);
}

}  // namespace
}  // namespace tactel::hw::testing
