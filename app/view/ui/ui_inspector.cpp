// Over the picture: the numbers of the pixel under the mouse, while Alt is held.
#include <algorithm>
#include <cmath>

#include "app/view/ui/ui_parts.h"
#include "shared/display.h"

namespace app {
namespace {

/// The value of an image at (u, v) in [0,1]^2, or null for an image that is not there.
const float* valueAt(const core::Image& image, float u, float v)
{
    if (image.width == 0 || image.height == 0 || image.pixels.empty()) return nullptr;
    const auto index = [](float t, uint32_t count) {
        return std::min(static_cast<uint32_t>(std::max(t, 0.0f) * static_cast<float>(count)),
                        count - 1);
    };
    return image.at(index(u, image.width), index(v, image.height));
}

std::string rgbText(const float* rgb)
{
    return format("%9.4g %9.4g %9.4g", static_cast<double>(rgb[0]), static_cast<double>(rgb[1]),
                  static_cast<double>(rgb[2]));
}

void row(const char* name, const std::string& value)
{
    dimText(name);
    ImGui::SameLine(6.5f * ImGui::GetFontSize());
    ImGui::TextUnformatted(value.c_str());
}

void aovRows(const core::Aovs& aovs, float u, float v, double perMetre)
{
    if (const float* depth = valueAt(aovs.depth, u, v)) {
        row("distance", depth[0] > 0 ? format("%.5g m", static_cast<double>(depth[0]) / perMetre)
                                     : "nothing hit");
    }
    if (const float* normal = valueAt(aovs.normal, u, v)) row("normal", rgbText(normal));
    if (const float* albedo = valueAt(aovs.albedo, u, v)) row("albedo", rgbText(albedo));
    if (const float* ids = valueAt(aovs.ids, u, v)) {
        row("ids", format("triangle %.0f, material %.0f, emitter %.0f", static_cast<double>(ids[0]),
                          static_cast<double>(ids[1]), static_cast<double>(ids[2])));
    }
}

void mapRows(const Picture& picture, float u, float v)
{
    const auto infos = core::methodNamed(picture.params.method.id()).maps;
    for (size_t i = 0; i < std::min(picture.maps->size(), infos.size()); ++i)
        if (const float* value = valueAt((*picture.maps)[i], u, v))
            row(infos[i].name, format("%.4g", static_cast<double>(*value)));
}

/// What the method knows of the place, in the colours of maps: from nothing to the largest value.
void drawProbe(const UiContext& c, const Picture& picture, float u, float v)
{
    const glm::vec2 size(float(picture.mean.width), float(picture.mean.height));
    const auto place = picture.probe->at(glm::uvec2(glm::vec2(u, v) * size));
    if (!place) return;
    const core::Image& image = place->image;
    const float largest = *std::max_element(image.pixels.begin(), image.pixels.end());
    dimText(place->caption.c_str());
    const float step = 12 * ImGui::GetFontSize() / float(image.width);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    for (uint32_t y = 0; y < image.height; ++y) {
        for (uint32_t x = 0; x < image.width; ++x) {
            const float value = *image.at(x, y);
            if (value < 0) continue;
            const float t = largest > 0 ? value / largest : 0;
            const glm::vec3 rgb = shared::displayMap(uint32_t(c.session.settings.view.map), t);
            const ImVec2 at(corner.x + float(x) * step, corner.y + float(y) * step);
            ImGui::GetWindowDrawList()->AddRectFilled(
                at, {at.x + step, at.y + step}, ImGui::GetColorU32(ImVec4(rgb.x, rgb.y, rgb.z, 1)));
        }
    }
    ImGui::Dummy({step * float(image.width), step * float(image.height)});
    row("brightest", format("%.4g per steradian", double(largest)));
}

}  // namespace

void drawInspector(const UiContext& c)
{
    const ImGuiIO& io = ImGui::GetIO();
    const auto picture = shownPicture(c);
    c.session.inspecting = io.KeyAlt && picture && !io.WantCaptureMouse;
    if (!c.session.inspecting) return;
    const Area place = c.session.placeOf(*picture);
    const glm::vec2 inArea(c.picture.fraction({io.MousePos.x, io.MousePos.y}));
    const float u = (inArea.x - place.corner.x) / place.size.x;
    const float v = (inArea.y - place.corner.y) / place.size.y;
    if (!(u >= 0 && u < 1 && v >= 0 && v < 1)) return;
    const float* radiance = valueAt(picture->mean, u, v);
    if (radiance == nullptr) return;
    ImGui::BeginTooltip();
    row("pixel", format("%.0f, %.0f", std::floor(static_cast<double>(u) * picture->fullSize.x),
                        std::floor(static_cast<double>(v) * picture->fullSize.y)));
    row("radiance", rgbText(radiance));
    if (picture->variance) {
        if (const float* variance = valueAt(*picture->variance, u, v)) {
            const float deviation[3] = {std::sqrt(variance[0]), std::sqrt(variance[1]),
                                        std::sqrt(variance[2])};
            row("\xC2\xB1", rgbText(deviation));
        }
    }
    if (const auto reference = c.session.reference();
        reference && c.session.referenceFits(*picture)) {
        if (const float* value = valueAt(reference->mean, u, v)) row("reference", rgbText(value));
    }
    if (const auto world = picture->world.lock(); world && picture->aovs)
        aovRows(*picture->aovs, u, v, world->placement.scale);
    if (picture->maps) mapRows(*picture, u, v);
    if (picture->probe) drawProbe(c, *picture, u, v);
    ImGui::EndTooltip();
}

}  // namespace app
