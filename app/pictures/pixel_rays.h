// Rays through the centres of a picture's pixels, the points that they meet, and back.
#pragma once

#include <cmath>
#include <optional>

#include <glm/glm.hpp>

#include "core/scene/camera.h"

namespace app {

class PixelRays {
public:
    PixelRays(const core::Camera& camera, uint32_t width, uint32_t height)
        : forward_(camera.forward), orthographic_(camera.orthographic),
          pixel_(2.0 / width, 2.0 / height), size_(width, height)
    {
        const double half = camera.orthographic ? camera.ymag : std::tan(0.5 * camera.yfov);
        up_ = half * camera.up;
        right_ = half * width / height * glm::cross(camera.forward, camera.up);
    }

    glm::vec3 direction(uint32_t x, uint32_t y) const
    {
        return orthographic_ ? forward_ : glm::normalize(forward_ + across(x, y));
    }

    /// The point at that distance along the ray, seen from the camera.
    glm::vec3 point(uint32_t x, uint32_t y, float distance) const
    {
        const glm::vec3 from = orthographic_ ? across(x, y) : glm::vec3(0);
        return from + distance * direction(x, y);
    }

    /// Where a point (relative to the camera) is seen, in pixels from the centre of the first one;
    /// nothing where it is not in front.
    std::optional<glm::vec2> film(const glm::vec3& point) const
    {
        const float ahead = orthographic_ ? 1 : glm::dot(point, forward_);
        if (!(ahead > 0)) return std::nullopt;
        const glm::vec2 uv(glm::dot(point, right_) / glm::dot(right_, right_),
                           glm::dot(point, up_) / glm::dot(up_, up_));
        return 0.5f * size_ * (1.0f + glm::vec2(uv.x, -uv.y) / ahead) - 0.5f;
    }

private:
    glm::vec3 across(uint32_t x, uint32_t y) const
    {
        const float u = (static_cast<float>(x) + 0.5f) * pixel_.x - 1,
                    v = 1 - (static_cast<float>(y) + 0.5f) * pixel_.y;
        return u * right_ + v * up_;
    }

    glm::vec3 forward_, right_{0}, up_{0};
    bool orthographic_;
    glm::vec2 pixel_, size_;
};

}  // namespace app
