// SPDX-License-Identifier: Apache-2.0
#include "hw/recording.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <bit>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <vector>

#include "tests/hw/byte_vectors.h"
#include "tests/scratch.h"

namespace tactel::hw::tests::recording_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class Recording : public ::testing::Test {
 protected:
  /// 600 packets of 17 bytes at odd times, a gap before packet 100.
  void record() const {
    RecordingWriter writer(path_, "[device]\nformat = \"glove\"\n");
    for (std::size_t i = 0; i < packets; ++i)
      writer.write({Bytes(stream_).subspan(17 * i, 17), 0.1 * static_cast<double>(i), i == 100});
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
  const ScratchFolder folder_;
  const fs::path path_ = folder_ / "glove.tactel";
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

/// Records by hand, as hw/README.md describes them.
ByteVector record_of(char kind, const ByteVector& body) {
  ByteVector bytes{static_cast<std::uint8_t>(kind)};
  put(bytes, body.size(), 4);
  append(bytes, body);
  put(bytes, crc32(bytes), 4);
  return bytes;
}

ByteVector packet_of(double arrival, const ByteVector& bytes) {
  ByteVector body;
  put(body, std::bit_cast<std::uint64_t>(arrival), 8);
  body.push_back(0);
  append(body, bytes);
  return record_of('P', body);
}

/// A file of these records behind the magic and an empty description.
void write_records(const fs::path& path, const std::vector<ByteVector>& records) {
  ByteVector bytes{'t', 'a', 'c', 't', 'e', 'l', '1', '\n'};
  append(bytes, record_of('D', {}));
  for (const ByteVector& record : records) append(bytes, record);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
}

std::size_t packets_in(FrameSource& source) {
  std::size_t count = 0;
  while (source.wait(0)) ++count;
  return count;
}

TEST_F(Recording, AnArrivalThatIsNoTimeIsDamage) {
  for (const double arrival :
       {std::nan(""), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), -1.0, 1e300}) {
    write_records(path_, {packet_of(0.5, {1}), packet_of(arrival, {2})});
    for (const bool real_time : {false, true}) {
      ReplaySource source(path_, real_time);
      EXPECT_TRUE(source.wait(1));
      EXPECT_THAT([&] { source.wait(0); }, ThrowsMessage<RecordingError>(HasSubstr("no time"))) << arrival;
    }
  }
}

TEST_F(Recording, AnEndThatIsNotWholeIsCutOffAndADamagedOneIsDamage) {
  write_records(path_, {packet_of(0.5, {1}), record_of('I', ByteVector(100000, 7))});
  const auto size = fs::file_size(path_);
  damage(static_cast<std::streamoff>(size - 50));
  ReplaySource damaged(path_);
  EXPECT_THROW(packets_in(damaged), RecordingError);
  for (const std::uintmax_t missing : {1u, 4u, 50000u, 100007u, 100008u, 100009u}) {
    write_records(path_, {packet_of(0.5, {1}), record_of('I', ByteVector(100000, 7))});
    fs::resize_file(path_, size - missing);
    ReplaySource source(path_);
    EXPECT_EQ(packets_in(source), 1u);
    EXPECT_TRUE(source.cut_short()) << missing << " bytes are missing";
  }
}

// Memory and file hold nothing besides the packets, however many they are.
TEST_F(Recording, GrowsByItsPacketsAlone) {
  const auto size_with = [&](int packets) {
    RecordingWriter writer(path_, "", OutputFile::Existing::replace);
    for (int i = 0; i < packets; ++i) writer.write({Bytes(stream_).first(4), 0.0});
    writer.finish();
    return fs::file_size(path_);
  };
  EXPECT_EQ(size_with(3000) - size_with(1000), 2000 * (9 + 9 + 4));
}

TEST_F(Recording, AnotherFileIsNotWrittenOverUnasked) {
  std::ofstream(path_) << "precious";
  EXPECT_THAT([&] { RecordingWriter(path_, ""); },
              ThrowsMessage<RecordingError>(HasSubstr("exists and is not overwritten")));
  EXPECT_EQ(fs::file_size(path_), 8u);
  const fs::path link = path_.parent_path() / "link";
  fs::create_symlink(path_.parent_path() / "behind", link);
  EXPECT_THROW(RecordingWriter(link, ""), RecordingError);
  EXPECT_THROW(RecordingWriter(link, "", OutputFile::Existing::replace), RecordingError);
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_FALSE(fs::exists(path_.parent_path() / "behind"));
  EXPECT_THROW(RecordingWriter(path_.parent_path(), "", OutputFile::Existing::replace), RecordingError) << "a folder";
  RecordingWriter(path_, "", OutputFile::Existing::replace).finish();
  EXPECT_NE(fs::file_size(path_), 8u);
}

TEST_F(Recording, AFullDiskIsSaidAtOnce) {
  EXPECT_THAT([] { RecordingWriter("/dev/full", ""); }, ThrowsMessage<RecordingError>(HasSubstr("No space left")));
}

/// While one lives a file may grow to `bytes`, and then a write fails.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~FileLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(Recording, ADiskThatFillsUpIsSaidAndThePacketsBeforeAreReadable) {
  const FileLimit limit(20000);
  RecordingWriter writer(path_, "");
  EXPECT_THAT(
      [&] {
        for (std::size_t i = 0; i < packets; ++i) writer.write({Bytes(stream_).first(100), 0.0});
        writer.finish();
      },
      ThrowsMessage<RecordingError>(HasSubstr("cannot be written")));
  ReplaySource source(path_);
  EXPECT_EQ(packets_in(source), (20000u - 8 - 9) / (9 + 9 + 100));
  EXPECT_TRUE(source.cut_short());
}

// The last block goes out in finish alone.
TEST_F(Recording, WhatOnlyTheEndFindsOutIsSaid) {
  const FileLimit limit(100);
  RecordingWriter writer(path_, "");
  writer.write({Bytes(stream_).first(200), 0.0});
  EXPECT_THROW(writer.finish(), RecordingError);
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
  EXPECT_THAT([&] { ReplaySource{path_}; }, ThrowsMessage<SourceError>(HasSubstr("not a recording")));
  EXPECT_THAT([&] { ReplaySource{path_.parent_path() / "none"}; },
              ThrowsMessage<SourceError>(HasSubstr("cannot be read")));
  EXPECT_THROW(RecordingWriter("/no/such/folder/file", ""), SourceError);
}

TEST_F(Recording, PlaysInRealTimeWhenAsked) {
  RecordingWriter writer(path_, "");
  writer.write({Bytes(stream_).first(4), 5.0});
  writer.write({Bytes(stream_).first(4), 5.05});
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

}  // namespace tactel::hw::tests::recording_test
