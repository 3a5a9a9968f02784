// SPDX-License-Identifier: Apache-2.0
#include "host/sets/direct_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>

namespace tactel::host {

void Pages::Free::operator()(char* memory) const { std::free(memory); }

Pages::Pages(std::size_t bytes)
    : memory_(static_cast<char*>(std::aligned_alloc(page_bytes, whole_pages(bytes)))), size_(whole_pages(bytes)) {
  if (!memory_) throw std::bad_alloc();
  if (size_ > 0) std::memset(data() + size_ - page_bytes, 0, page_bytes);
}

DirectFile::DirectFile(const std::filesystem::path& path) {
  constexpr int usual = O_WRONLY | O_CLOEXEC | O_NOFOLLOW;
  file_ = ::open(path.c_str(), usual | O_DIRECT);
  direct_ = file_ >= 0;
  if (!direct_ && errno == EINVAL) file_ = ::open(path.c_str(), usual);
  if (file_ < 0) throw std::system_error(errno, std::generic_category());
}

DirectFile::~DirectFile() {
  if (file_ >= 0) ::close(file_);
}

bool DirectFile::write(std::uint64_t at, const Pages& pages) {
  for (std::size_t from = 0; from < pages.size();) {
    const ssize_t count = ::pwrite(file_, pages.data() + from, pages.size() - from, static_cast<off_t>(at + from));
    if (count >= 0) {
      from += static_cast<std::size_t>(count);
    } else if (errno == EINVAL && direct_) {  // a disk with larger pages
      direct_ = false;
      if (::fcntl(file_, F_SETFL, ::fcntl(file_, F_GETFL) & ~O_DIRECT) != 0) return false;
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

}  // namespace tactel::host
