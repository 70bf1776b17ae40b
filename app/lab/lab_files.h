// The results of the laboratory as files for other programs: lab.json and tables in CSV.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/lab/results.h"

namespace app::lab {

/// "none", "ideal" or "own".
const char* betaName(Beta beta);

/// A table that is written beside lab.json and index.html.
struct LabFile {
    const char* name;
    const char* key;      // of the same in lab.json
    const char* meaning;  // what it holds, in a line
};
std::span<const LabFile> labFiles();

/// Everything, as JSON. What is infinite is the text "infinite", what is not known is null.
std::string labJson(const LabResults& results);

/// Name and content of each of labFiles(): a row of names, then one row per cell, point, frame,
/// pixel, variant or trap. What is infinite is the word infinite, what is not known is empty;
/// fields with commas or quotes are quoted (RFC 4180).
std::vector<std::pair<std::string, std::string>> labTables(const LabResults& results);

/// Writes lab.json, the tables and index.html into `folder`, which exists. Each file appears when
/// it is complete. Throws core::Error.
void writeLabFiles(const std::filesystem::path& folder, const LabResults& results);

}  // namespace app::lab
