// Over the picture: the colours of a view of numbers, with the numbers.
#include <algorithm>
#include <cmath>

#include "app/view/ui/ui_parts.h"
#include "shared/display.h"

namespace app {
namespace {

static_assert(static_cast<uint32_t>(ColourMap::viridis) == shared::kMapViridis &&
              static_cast<uint32_t>(ColourMap::magma) == shared::kMapMagma &&
              static_cast<uint32_t>(ColourMap::grey) == shared::kMapGrey);

ImU32 scaleColour(const UiContext& c, float t)
{
    const auto map = static_cast<uint32_t>(c.session.settings.view.map);
    const glm::vec3 rgb =
        c.frame.scale.isSigned ? shared::displaySigned(2 * t - 1) : shared::displayMap(map, t);
    return ImGui::GetColorU32(ImVec4(rgb.x, rgb.y, rgb.z, 1));
}

/// The value at the fraction t of a scale.
double scaleValue(const Scale& scale, double t)
{
    const auto low = static_cast<double>(scale.low), high = static_cast<double>(scale.high);
    return (scale.logarithmic && low > 0 ? low * std::pow(high / low, t) : low + t * (high - low)) *
           static_cast<double>(scale.unit);
}

std::string scaleText(const Scale& scale, double t)
{
    const double value = scaleValue(scale, t);
    if (scale.whole) return format("%.0f", value);
    const auto largest =
        static_cast<double>(scale.unit * std::max(std::abs(scale.low), std::abs(scale.high)));
    if (scale.logarithmic || !(largest >= 1e-3 && largest < 1e4)) return digitsText(value);
    const int decimals = std::clamp(2 - static_cast<int>(std::floor(std::log10(largest))), 0, 5);
    return format("%.*f", decimals, value == 0 ? 0.0 : value);
}

/// Where a text begins that stands in the middle of its place.
float textStart(double at, float width, float length)
{
    return std::clamp(static_cast<float>(at) * length - 0.5f * width, 0.0f,
                      std::max(length - width, 0.0f));
}

void drawScaleNumbers(const UiContext& c, ImVec2 corner, float width)
{
    std::vector<ScaleNumber> numbers;
    std::vector<float> widths;
    for (int count = 5; count >= 2; --count) {  // fewer where they would touch
        numbers = scaleNumbers(c.frame.scale, count);
        widths.clear();
        for (const ScaleNumber& number : numbers)
            widths.push_back(ImGui::CalcTextSize(number.text.c_str()).x);
        if (stayApart(numbers, widths, width, 0.7f * c.em)) break;
    }
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const float top = ImGui::GetCursorScreenPos().y;
    for (size_t i = 0; i < numbers.size(); ++i) {
        const float x = corner.x + static_cast<float>(numbers[i].at) * (width - 1);
        list.AddLine({x, corner.y}, {x, corner.y + 3}, ImGui::GetColorU32(ImGuiCol_Text));
        list.AddText({corner.x + textStart(numbers[i].at, widths[i], width), top},
                     ImGui::GetColorU32(ImGuiCol_Text), numbers[i].text.c_str());
    }
}

void drawScale(const UiContext& c, float width)
{
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float height = 0.9f * c.em;
    constexpr int kSteps = 64;
    for (int i = 0; i < kSteps; ++i) {
        const float a = static_cast<float>(i) / kSteps, b = static_cast<float>(i + 1) / kSteps;
        const ImU32 left = scaleColour(c, a), right = scaleColour(c, b);
        list.AddRectFilledMultiColor({corner.x + a * width, corner.y},
                                     {corner.x + b * width, corner.y + height}, left, right, right,
                                     left);
    }
    ImGui::Dummy(ImVec2(width, height));
    drawScaleNumbers(c, {corner.x, corner.y + height}, width);
    ImGui::Dummy(ImVec2(width, ImGui::GetTextLineHeight()));
}

}  // namespace

std::vector<ScaleNumber> scaleNumbers(const Scale& scale, int count)
{
    std::vector<ScaleNumber> numbers;
    for (int i = 0; i < count; ++i) {
        double at = static_cast<double>(i) / std::max(count - 1, 1);
        if (scale.whole && scale.high > scale.low) {
            const auto low = static_cast<double>(scale.low), high = static_cast<double>(scale.high);
            at = (std::round(low + at * (high - low)) - low) / (high - low);
        }
        if (numbers.empty() || at > numbers.back().at)
            numbers.push_back({at, scaleText(scale, at)});
    }
    return numbers;
}

bool stayApart(const std::vector<ScaleNumber>& numbers, const std::vector<float>& widths,
               float length, float gap)
{
    for (size_t i = 1; i < numbers.size(); ++i)
        if (textStart(numbers[i - 1].at, widths[i - 1], length) + widths[i - 1] + gap >
            textStart(numbers[i].at, widths[i], length))
            return false;
    return true;
}

void drawColourBar(const UiContext& c)
{
    if (!c.frame.scale.shown && c.frame.problem.empty()) return;
    const ImGuiStyle& style = ImGui::GetStyle();
    const glm::vec2 padding(2 * style.WindowPadding.x, 2 * style.WindowPadding.y);
    const glm::vec2 size(24 * c.em, 3.2f * c.em + 3 * style.ItemSpacing.y);
    const Area bar = placeBar(c.picture, size + padding, 12 * c.em, c.state.plot, 0.7f * c.em);
    const float width = bar.size.x - padding.x;
    if (width < 8 * c.em) return;
    ImGui::SetNextWindowPos(ImVec2(bar.corner.x, bar.end().y), ImGuiCond_Always, ImVec2(0, 1));
    ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(bar.size.x, c.picture.size.y));
    ImGui::SetNextWindowBgAlpha(0.72f);
    if (ImGui::Begin("##colour bar", nullptr, kOverlay | ImGuiWindowFlags_AlwaysAutoResize)) {
        if (!c.frame.problem.empty())
            ImGui::TextColored(kWarningColour, "%s", c.frame.problem.c_str());
        if (c.frame.scale.shown) {
            ImGui::PushTextWrapPos(width + 0.5f * padding.x);
            ImGui::TextUnformatted(c.frame.scale.label.c_str());
            ImGui::PopTextWrapPos();
            drawScale(c, width);
        }
    }
    ImGui::End();
}

}  // namespace app
