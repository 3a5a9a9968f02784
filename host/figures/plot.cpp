// SPDX-License-Identifier: Apache-2.0
#include "host/figures/plot.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "host/support/bounded_file.h"
#include "host/support/child_process.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t largest_picture = std::uintmax_t{1} << 30;

/// A folder of our own under the system's temporary one; gone when this is.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_((fs::temp_directory_path() / "tactel-plot-XXXXXX").string()) {
    if (::mkdtemp(path_.data()) == nullptr) throw PlotError("no temporary folder could be made: " + path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path operator/(const std::string& name) const { return fs::path(path_) / name; }

 private:
  std::string path_;
};

/// Empty where none was made.
std::string read_picture(const fs::path& path) try {
  return read_bounded_file(path, largest_picture);
} catch (const UnreadableFile&) {
  return "";
}

/// The bytes of the figure as "png", two pixels for one, to stay sharp; or as "pdf".
std::string converted(const Figure& figure, const std::string& format) {
  const TemporaryFolder folder;
  const fs::path svg = folder / "figure.svg", picture = folder / "figure.out";
  write_file("figure", svg, render_svg(figure));
  const ChildResult result = run_child({"rsvg-convert", "--format", format, "--zoom", format == "png" ? "2" : "1",
                                        "--output", picture.string(), svg.string()});
  std::string drawn = read_picture(picture);
  if (result.exit_code != 0 || drawn.empty())
    throw PlotError(fmt::format("rsvg-convert ended with {}: {}", result.exit_code, result.err));
  return drawn;
}

}  // namespace

void check_figure_path(const std::string& option, const fs::path& path) {
  const std::string ending = path.extension().string();
  const auto refuse = [&](const char* allowed) { throw ConfigError("command line", option, path.string(), allowed); };
  if (ending != ".svg" && ending != ".png" && ending != ".pdf") refuse("a file name that ends in .svg, .png or .pdf");
  if (ending != ".svg" && !program_exists("rsvg-convert"))
    refuse(
        "a file name that ends in .svg, or rsvg-convert installed (apt-get install librsvg2-bin): it makes .png and "
        ".pdf");
  check_writable(option, path);
}

void write_figure(const std::string& option, const fs::path& path, const Figure& figure) {
  check_figure_path(option, path);
  const std::string ending = path.extension().string();
  write_file(option, path, ending == ".svg" ? render_svg(figure) : converted(figure, ending.substr(1)));
}

}  // namespace tactel::host
