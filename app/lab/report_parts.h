// The sections of the report and the words they share. Only report*.cpp include this. Codes never
// stand alone on the page: "F6 peaks" in tables and plots, "peaks (F6)" in sentences.
#pragma once

#include <string>
#include <vector>

#include "app/lab/report_data.h"
#include "app/lab/results.h"
#include "app/report/map.h"
#include "app/report/page.h"
#include "app/report/svg.h"
#include "app/report/text.h"

namespace app::lab {

using namespace report;  // every section is made of its pieces

// Each is a whole section element, or empty where there is nothing to show.
std::string pictureSection(const LabResults& results);
std::string summarySection(const LabResults& results);
std::string ideaSection();
std::string winnersSection(const LabResults& results);
std::string lossesSection(const LabResults& results);
std::string methodsSection();
std::string pairsSection();
std::string tableSection(const LabResults& results);
std::string checksSection(const LabResults& results);
std::string sweepsSection(const LabResults& results);
std::string majorisationSection(const LabResults& results);
std::string lobesSection(const LabResults& results);
/// The part of it about what a history keeps; empty without results.
std::string storesPart(const LabResults& results);
std::string flatlandSection(const LabResults& results);
std::string trapsSection(const LabResults& results);
std::string filesSection();

/// "F6 peaks" and "D2 small shift"; the code alone where it is not known.
std::string functionLabel(const std::string& id);
std::string pairLabel(const std::string& id);
/// "small shift (D2), peaks (F6)".
std::string rowWords(const Row& row);

/// Changes of density downwards, functions across, in the order in which the cells came; `cell`
/// tells what stands where.
Map rowMap(const std::string& title, const CellTable& table,
           const std::function<MapCell(const Row&)>& cell);

/// A map with its caption: what is read from it. `id` may be empty.
std::string mapFigure(const Map& map, const std::string& caption, const std::string& id = "");

/// Where the map stands that shows, row by row, who wins the duel.
std::string duelId(const Column& a, const Column& b);

/// The column of R-A that stands for it in sentences.
Column usualRa(Beta beta);

}  // namespace app::lab
