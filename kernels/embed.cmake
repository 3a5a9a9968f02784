# Writes every kernel source into one C++ table of strings.
# cmake -DROOT=<kernels folder> -DFILES=<a.cl,shared/b.h,...> -DOUTPUT=<file.cpp> -P embed.cmake
string(REPLACE "," ";" names "${FILES}")
set(table "")
foreach(name IN LISTS names)
  file(READ "${ROOT}/${name}" text)
  string(APPEND table "    {R\"embedded(${name})embedded\", R\"embedded(${text})embedded\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "// Made from the files of kernels/ by embed.cmake; edit those.
#include \"kernels/embedded.h\"

namespace tactel::kernels {
namespace {
constexpr Source table[] = {
${table}};
}
std::span<const Source> sources() { return table; }
}  // namespace tactel::kernels
")
