#include "host/checksum.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace tactel::host {

std::uint64_t checksum(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string checksum_text(std::string_view bytes) { return fmt::format("{:016x}", checksum(bytes)); }

}  // namespace tactel::host
