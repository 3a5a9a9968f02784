// SPDX-License-Identifier: Apache-2.0

// Files that have no end, no writer or no bytes of a file.
#include "host/support/bounded_file.h"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "tests/host/support/run_tactel.h"

namespace tactel::host::bounded_file_test {

using testing::HasSubstr;

/// Why a file is not read; empty where it is.
std::string refusal(const std::filesystem::path& path, std::uintmax_t most = 1 << 20) try {
  read_bounded_file(path, most);
  return "";
} catch (const UnreadableFile& error) {
  return error.what();
}

TEST(BoundedFile, GivesTheBytesOfAFile) {
  const ScratchFolder folder;
  const std::string bytes("a\0b\r\n\xFF", 6);
  EXPECT_EQ(read_bounded_file(folder.write("six", bytes), 6), bytes);
  EXPECT_EQ(read_bounded_file(folder.write("none", ""), 0), "");
  std::filesystem::create_symlink(folder / "six", folder / "link");
  EXPECT_EQ(read_bounded_file(folder / "link", 100), bytes);
}

TEST(BoundedFile, ALargerOneIsRefusedUnread) {
  const ScratchFolder folder;
  folder.write("seven", "1234567");
  EXPECT_EQ(refusal(folder / "seven", 7), "");
  EXPECT_EQ(refusal(folder / "seven", 6), "it is larger than 6 bytes");
  std::filesystem::resize_file(folder / "seven", std::uintmax_t{1} << 40);  // a hole: it takes no room
  EXPECT_EQ(refusal(folder / "seven", 16 << 20), "it is larger than 16 MiB");
}

TEST(BoundedFile, ANameWithANulByteIsNotCut) {
  const ScratchFolder folder;
  const std::string path = folder.write("file", "content");
  EXPECT_EQ(refusal(path + std::string("\0x", 2)), "its name holds a NUL byte");
}

TEST(BoundedFile, OneThatIsNotThereIsMissing) {
  const ScratchFolder folder;
  folder.write("file", "");
  for (const std::string name : {"absent", "file/below", "absent/below"}) try {
      read_bounded_file(folder / name, 1);
      ADD_FAILURE() << name;
    } catch (const UnreadableFile& error) {
      EXPECT_TRUE(error.missing) << name;
    }
  std::filesystem::create_symlink(folder / "nowhere", folder / "dangling");
  EXPECT_EQ(refusal(folder / "dangling"), "No such file or directory");
  std::filesystem::create_symlink(folder / "round", folder / "round");
  EXPECT_THAT(refusal(folder / "round"), HasSubstr("symbolic links"));
}

TEST(BoundedFile, AFolderIsRefused) {
  const ScratchFolder folder;
  EXPECT_EQ(refusal(folder / ""), "it is a folder");
}

TEST(BoundedFile, ADeviceIsRefused) {
  for (const char* device : {"/dev/zero", "/dev/null", "/dev/urandom", "/dev/tty"})
    EXPECT_EQ(refusal(device), "it is no regular file") << device;
}

TEST(BoundedFile, APipeWithoutAWriterIsRefusedAtOnce) {
  const ScratchFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(refusal(folder / "pipe"), "it is no regular file");
  std::filesystem::create_symlink(folder / "pipe", folder / "link");
  EXPECT_EQ(refusal(folder / "link"), "it is no regular file");
}

TEST(BoundedFile, ASocketIsRefused) {
  const ScratchFolder folder;
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  const std::string name = (folder / "socket").string();
  ASSERT_LT(name.size(), sizeof address.sun_path);
  name.copy(address.sun_path, name.size());
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(refusal(name), "it is no regular file");
  ::close(socket);
}

// The kernel gives these a size of 0, and bytes all the same.
TEST(BoundedFile, AFileWithMoreBytesThanItsSizeIsRefused) {
  EXPECT_EQ(refusal("/proc/self/maps"), "it changed while it was read");
}

// What is read is never more than the file had at one time, and never more than asked for.
TEST(BoundedFile, AFileThatGrowsIsRefusedOrReadAsItWas) {
  const ScratchFolder folder;
  const std::string name = folder.write("log", std::string(100'000, 'x'));
  std::atomic<bool> enough = false;
  std::jthread writer([&] {
    std::ofstream log(name, std::ios::app);
    while (!enough) log << std::string(100, 'x') << std::flush;
  });
  for (int i = 0; i < 200; ++i) try {
      EXPECT_LE(read_bounded_file(name, 50'000'000).size(), 50'000'000u);
    } catch (const UnreadableFile& error) {
      EXPECT_THAT(error.what(), testing::AnyOf(HasSubstr("changed"), HasSubstr("larger")));
    }
  enough = true;
}

}  // namespace tactel::host::bounded_file_test
