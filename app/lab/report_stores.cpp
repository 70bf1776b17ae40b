// What a history should keep: one table. See report_parts.h.
#include <map>
#include <set>
#include <tuple>

#include "app/base/read_value.h"
#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

/// K, cap and brightness: what a row stands for.
using Store = std::tuple<uint32_t, double, double>;

std::string nameOf(const Store& store)
{
    const auto& [kept, cap, brightness] = store;
    std::string name = std::to_string(kept) + " kept, N up to " + numberText(cap);
    if (brightness > 0) name += ", bright ones spared (η = " + numberText(brightness) + ")";
    return name;
}

}  // namespace

std::string storesPart(const LabResults& results)
{
    if (results.stores.empty()) return {};
    std::set<double> steps;
    std::map<Store, std::map<double, double>> rows;
    std::vector<Store> order;
    for (const StoreResult& s : results.stores) {
        const Store store{s.kept, s.cap, s.brightness};
        if (rows[store].empty()) order.push_back(store);
        rows[store][s.step] = s.lateVarianceRatio;
        steps.insert(s.step);
    }
    const std::string html =
        "<h3>What to keep</h3>\n" +
        paragraph(
            "A history keeps K samples, but may stand for more: N, the nominal count that c is "
            "solved with, can grow beyond K, and new samples then go where so many old ones leave "
            "something to do. That pays when the few that are kept are the ones that matter, and "
            "costs when they are chosen by their weight alone: a score u (p + η f/I) spares bright "
            "ones. When the lobe moves so fast that few old samples are of use, a large N trusts "
            "them too much. R-A with k = 8, four new samples a frame; variance relative to Discard "
            "in the frames 30 to 39.");
    std::string head = "<th>store</th>", body;
    for (const double step : steps) head += numberHead("δ = " + numberText(step));
    for (const Store& store : order) {
        body += "<tr><td>" + nameOf(store) + "</td>";
        for (const double step : steps) {
            const auto value = rows[store].find(step);
            body += numberCell(value == rows[store].end() ? "·" : shortNumber(value->second));
        }
        body += "</tr>\n";
    }
    return html + tableMarkup(head, body) +
           dataLine("stores.csv", {"step", "kept", "cap", "brightness", "late_variance_ratio"});
}

}  // namespace app::lab
