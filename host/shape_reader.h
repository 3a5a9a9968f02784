#pragma once
#include "fem/indenter.h"
#include "host/toml_table.h"

namespace tactel::host {

/// Reads the table [indenter]. Every number that the named shape needs must be there, and none of another shape may;
/// with `preset` what `indenter` holds already stands in for what is missing. A measured profile is read from beside
/// the file.
void read_indenter(const TomlFile& file, fem::Indenter& indenter, bool preset);

}  // namespace tactel::host
