# SPDX-License-Identifier: Apache-2.0

# Writes network files into one C++ table: cmake -DFILES=<a.onnx,b.onnx,...> -DOUTPUT=<file.cpp> -P embed.cmake
string(REPLACE "," ";" paths "${FILES}")
set(arrays "")
set(table "")
foreach(path IN LISTS paths)
  get_filename_component(name "${path}" NAME_WLE)
  string(MAKE_C_IDENTIFIER "${name}" array)
  file(READ "${path}" bytes HEX)
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${bytes}")
  string(REGEX REPLACE "((\\\\x..)(\\\\x..)(\\\\x..)(\\\\x..)(\\\\x..)(\\\\x..)(\\\\x..)(\\\\x..))" "\\1\"\n    \"" bytes "${bytes}")
  string(APPEND arrays "constexpr char ${array}[] =\n    \"${bytes}\";\n")
  string(APPEND table "    {\"${name}\", {${array}, sizeof ${array} - 1}},\n")
endforeach()
file(WRITE "${OUTPUT}" "// Made from network files by embed.cmake.
#include \"nn/infer/built_in.h\"

namespace tactel::infer {
namespace {
${arrays}
struct Network {
  std::string_view name, bytes;
};
constexpr Network table[] = {
${table}};
}  // namespace

std::string_view built_in_network(std::string_view name) noexcept {
  for (const Network& network : table)
    if (network.name == name) return network.bytes;
  return {};
}

}  // namespace tactel::infer
")
