// Suggestions for mistyped names. See nearest.h.
#include "app/base/nearest.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace app {

size_t editDistance(std::string_view a, std::string_view b)
{
    const size_t columns = b.size() + 1;
    std::vector<size_t> d((a.size() + 1) * columns);
    for (size_t i = 0; i <= a.size(); ++i) d[i * columns] = i;
    for (size_t j = 0; j <= b.size(); ++j) d[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t replaced = d[(i - 1) * columns + j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            const size_t removed = d[(i - 1) * columns + j] + 1;
            const size_t added = d[i * columns + j - 1] + 1;
            size_t best = std::min({replaced, removed, added});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                best = std::min(best, d[(i - 2) * columns + j - 2] + 1);
            d[i * columns + j] = best;
        }
    }
    return d.back();
}

std::string nearestName(std::string_view word, std::span<const std::string> names)
{
    std::string best;
    size_t bestDistance = std::numeric_limits<size_t>::max();
    for (const std::string& name : names) {
        const size_t distance = editDistance(word, name);
        if (distance < bestDistance) {
            bestDistance = distance;
            best = name;
        }
    }
    // Two slips, or a third of a long word: further away is another word, not a slip. In three
    // letters every word is near every other.
    const size_t allowed = word.size() <= 3 ? 0 : std::max<size_t>(2, word.size() / 3);
    return bestDistance <= allowed ? best : std::string();
}

std::string suggestion(std::string_view word, std::span<const std::string> names)
{
    const std::string name = nearestName(word, names);
    return name.empty() ? name : "; did you mean " + name + "?";
}

}  // namespace app
