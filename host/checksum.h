#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace tactel::host {

/// XXH3, 64 bit (xxhash.com): the same for the same bytes on every machine.
std::uint64_t checksum(std::string_view bytes);
/// The same as 16 hexadecimal digits.
std::string checksum_text(std::string_view bytes);

}  // namespace tactel::host
