// SPDX-License-Identifier: Apache-2.0
#include "host/sets/staged_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>

namespace tactel::host {
namespace {

constexpr std::size_t block_bytes = 1 << 20;  ///< larger ones are no faster
constexpr std::size_t page_bytes = 4096;      ///< disks want offsets, lengths and memory in multiples of it

}  // namespace

void StagedFile::Free::operator()(char* memory) const { std::free(memory); }

StagedFile::StagedFile(const std::filesystem::path& path) {
  constexpr int usual = O_RDWR | O_CLOEXEC | O_NOFOLLOW;
  file_ = ::open(path.c_str(), usual | O_DIRECT);
  direct_ = file_ >= 0;
  if (!direct_ && errno == EINVAL) file_ = ::open(path.c_str(), usual);
  if (file_ < 0) throw std::system_error(errno, std::generic_category());
}

StagedFile::~StagedFile() {
  if (file_ >= 0) ::close(file_);
}

/// Returns a block with what the file has of it, none where that cannot be read.
StagedFile::Block* StagedFile::block_at(std::uint64_t number) {
  const auto [place, fresh] = blocks_.try_emplace(number);
  Block& block = place->second;
  if (!fresh) return &block;
  if (spare_.empty()) {
    block.memory.reset(static_cast<char*>(std::aligned_alloc(page_bytes, block_bytes)));
    if (!block.memory) throw std::bad_alloc();
  } else {
    block.memory = std::move(spare_.back());
    spare_.pop_back();
  }
  ssize_t there = 0;
  do there = ::pread(file_, block.memory.get(), block_bytes, static_cast<off_t>(number * block_bytes));
  while (there < 0 && errno == EINTR);
  if (there < 0) {
    blocks_.erase(place);
    return nullptr;
  }
  std::memset(block.memory.get() + there, 0, block_bytes - static_cast<std::size_t>(there));
  return &block;
}

bool StagedFile::write(std::uint64_t at, std::string_view bytes) {
  while (!bytes.empty()) {
    const std::uint64_t number = at / block_bytes;
    const std::size_t begin = at % block_bytes, size = std::min(bytes.size(), block_bytes - begin);
    Block* const block = block_at(number);
    if (!block) return false;
    std::memcpy(block->memory.get() + begin, bytes.data(), size);
    block->from = block->to == 0 ? begin : std::min(block->from, begin);
    block->to = std::max(block->to, begin + size);
    block->filled += size;
    if (block->filled == block_bytes) {
      if (!put(number, *block)) return false;
      spare_.push_back(std::move(block->memory));
      blocks_.erase(number);
    }
    at += size, bytes.remove_prefix(size);
  }
  return true;
}

bool StagedFile::flush() {
  return std::ranges::all_of(blocks_, [&](auto& numbered) { return put(numbered.first, numbered.second); });
}

/// Writes whole pages.
bool StagedFile::put(std::uint64_t number, Block& block) {
  std::size_t from = block.from / page_bytes * page_bytes;
  const std::size_t to = (block.to + page_bytes - 1) / page_bytes * page_bytes;
  while (from < to) {
    const ssize_t count =
        ::pwrite(file_, block.memory.get() + from, to - from, static_cast<off_t>(number * block_bytes + from));
    if (count >= 0) {
      from += static_cast<std::size_t>(count);
    } else if (errno == EINVAL && direct_) {  // a disk with larger pages
      direct_ = false;
      if (::fcntl(file_, F_SETFL, ::fcntl(file_, F_GETFL) & ~O_DIRECT) != 0) return false;
    } else if (errno != EINTR) {
      return false;
    }
  }
  block.from = block.to = 0;
  return true;
}

}  // namespace tactel::host
