// The sections of the report and the words they share. Only report*.cpp include this.
#pragma once

#include <string>
#include <vector>

#include "app/lab/report_data.h"
#include "app/lab/results.h"
#include "app/report/page.h"
#include "app/report/svg.h"
#include "app/report/text.h"

namespace app::lab {

using namespace report;  // every section is made of its pieces

// Each is a whole section element, or empty where there is nothing to show.
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

/// "D2: F5; D9: F1, F2" as text; "none" when there is none.
std::string rowList(const std::vector<Row>& rows);

/// The column of R-A that stands for it in sentences.
Column usualRa(Beta beta);

/// N Var to compare by: the expected one where there is one, else as measured.
double decidingVariance(const Cell& cell);

}  // namespace app::lab
