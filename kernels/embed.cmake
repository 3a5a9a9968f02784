# SPDX-License-Identifier: Apache-2.0

# Writes text files into one C++ table of strings.
# cmake -DROOT=<folder> -DFILES=<a.cl,shared/b.h,...> -DHEADER=<header.h> -DNAMESPACE=<name> -DOUTPUT=<file.cpp> -P embed.cmake
# The header declares, in the namespace, `struct Source` of a name and a text and `std::span<const Source> sources()`.
string(REPLACE "," ";" names "${FILES}")
set(table "")
foreach(name IN LISTS names)
  file(READ "${ROOT}/${name}" text)
  string(LENGTH "${text}" bytes)  # counted here: clang's constexpr has a limit of steps
  string(APPEND table "    {R\"embedded(${name})embedded\", {R\"embedded(${text})embedded\", ${bytes}}},\n")
endforeach()
file(WRITE "${OUTPUT}" "// Made from text files by embed.cmake; edit those.
#include \"${HEADER}\"

namespace ${NAMESPACE} {
namespace {
constexpr Source table[] = {
${table}};
}
std::span<const Source> sources() { return table; }
}  // namespace ${NAMESPACE}
")
