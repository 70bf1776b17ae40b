// Over the picture: the numbers of the pixel under the mouse, of what is on show there, while Alt
// is held.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

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

/// A picture on show, with what its line is called.
struct Seen {
    const char* name;
    std::shared_ptr<const Picture> picture;
};

/// The pictures on show, that under the cursor first. `x` in [0, 1] across the area.
std::vector<Seen> seenPictures(const UiContext& c, float x)
{
    const std::shared_ptr<const Picture> live = c.session.picture();
    if (!c.session.comparing) return {{"radiance", live}};
    const auto& [a, b] = c.session.slots;
    std::vector<Seen> seen{{"A", a.picture ? a.picture : live},
                           {"B", b.picture ? b.picture : live}};
    if (x > c.session.settings.view.compareAt) std::swap(seen[0], seen[1]);
    return seen;
}

/// Where that place of the area is in an image that has `place` there; nothing beside it.
std::optional<glm::vec2> placeIn(const Area& place, glm::vec2 inArea)
{
    const glm::vec2 at = (inArea - place.corner) / place.size;
    const bool inside = at.x >= 0 && at.x < 1 && at.y >= 0 && at.y < 1;
    return inside ? std::optional(at) : std::nullopt;
}

void radianceRows(const char* name, const core::Image& mean, const core::Image* variance,
                  glm::vec2 at)
{
    if (const float* radiance = valueAt(mean, at.x, at.y)) row(name, rgbText(radiance));
    const float* const v = variance != nullptr ? valueAt(*variance, at.x, at.y) : nullptr;
    if (v == nullptr) return;
    const float deviation[3] = {std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2])};
    row("\xC2\xB1", rgbText(deviation));
}

void pixelRow(glm::uvec2 size, glm::vec2 at)
{
    row("pixel", format("%.0f, %.0f", std::floor(static_cast<double>(at.x) * size.x),
                        std::floor(static_cast<double>(at.y) * size.y)));
}

/// The reference, which is shown while its key is held.
void heldReferenceRows(const UiContext& c, const Reference& reference, glm::vec2 inArea)
{
    const glm::uvec2 size(reference.mean.width, reference.mean.height);
    const auto at = placeIn(c.session.placeOf(size), inArea);
    if (!at) return;
    pixelRow(size, *at);
    radianceRows("reference", reference.mean, &reference.variance, *at);
}

/// The picture under the cursor, and beside it what it is compared with.
void pictureRows(const UiContext& c, glm::vec2 inArea)
{
    const std::vector<Seen> seen = seenPictures(c, inArea.x);
    const Picture& picture = *seen.front().picture;
    const auto at = placeIn(c.session.placeOf(picture), inArea);
    if (!at) return;
    pixelRow(picture.fullSize, *at);
    for (const Seen& each : seen)
        if (const auto there = placeIn(c.session.placeOf(*each.picture), inArea))
            radianceRows(each.name, each.picture->mean, each.picture->variance.get(), *there);
    const auto reference = c.session.reference();
    if (reference && c.session.referenceFits(picture))
        radianceRows("reference", reference->mean, nullptr, *at);
    if (const auto world = picture.world.lock(); world && picture.aovs)
        aovRows(*picture.aovs, at->x, at->y, world->placement.scale);
    if (picture.maps) mapRows(picture, at->x, at->y);
    if (picture.probe) drawProbe(c, picture, at->x, at->y);
}

}  // namespace

void drawInspector(const UiContext& c)
{
    const ImGuiIO& io = ImGui::GetIO();
    c.session.inspecting = io.KeyAlt && shownPicture(c) && !io.WantCaptureMouse;
    if (!c.session.inspecting) return;
    const glm::vec2 inArea(c.picture.fraction({io.MousePos.x, io.MousePos.y}));
    if (!placeIn({{0, 0}, {1, 1}}, inArea)) return;
    ImGui::BeginTooltip();
    if (const auto reference = c.session.reference(); reference && c.session.holdReference)
        heldReferenceRows(c, *reference, inArea);
    else
        pictureRows(c, inArea);
    ImGui::EndTooltip();
}

}  // namespace app
