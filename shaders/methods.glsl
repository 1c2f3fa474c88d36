// Ray segments by every method of vit_methods that a fragment can work out, one behind its own #define; M04's numbers.
// D: length; values: attenuation, or opacity, per unit length; `behind`: what comes in at the back.
float even_psi(float depth)
{
    // (1 - e^-d)/d; near 0 its series, where the difference would cancel.
    float series = 1.0 - depth * (1.0 / 2.0 - depth * (1.0 / 6.0 - depth * (1.0 / 24.0 - depth * (1.0 / 120.0 - depth / 720.0))));
    return depth > 0.3 ? (1.0 - exp(-min(depth, 80.0))) / depth : series;
}

float opacity_depth(float opacity, float D)
{
    return D * -log(max(1.0 - opacity, 1e-30));
}

vec3 linear_light(vec3 behind, vec3 back, vec3 front, float zeta, float psi)
{
    return behind * zeta + back * (psi - zeta) + front * (1.0 - psi);
}

vec3 even_light(vec3 behind, vec3 luminance, float zeta)
{
    return behind * zeta + luminance * (1.0 - zeta);
}

#if defined(VIT_METHOD_PSI_TABLE)
uniform sampler2D psi_table; // s: depth at the back, t: at the front, both as gamma; entry i at i/size
uniform float psi_table_size;

float table_psi(float a, float b)
{
    // 1 at infinite depth: a quotient of two infinities is not.
    vec2 gamma = vec2(a < 1e9 ? a / (1.0 + a) : 1.0, b < 1e9 ? b / (1.0 + b) : 1.0);
    vec2 entry = gamma * psi_table_size;
#if defined(VIT_METHOD_NEAREST)
    entry = floor(entry + 0.5);
#endif
    return VIT_TEXTURE_2D(psi_table, (entry + 0.5) / psi_table_size).r;
}
#endif

#if defined(VIT_METHOD_PREINTEGRATED)
// One transfer function and one length, as pre-integration has it: the light of segments of M04's grid (values and
// luminances at the front are 1 less those at the back), and what they hide. s: value, t: luminance at the back.
uniform sampler2D entries;
uniform float entries_size;
#endif

#if defined(VIT_METHOD_GAUSSIAN)
// Abramowitz and Stegun 7.1.26: |error| <= 1.5e-7.
float erf_of(float x)
{
    float t = 1.0 / (1.0 + 0.3275911 * abs(x));
    float poly = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    return sign(x) * (1.0 - poly * exp(-x * x));
}
#endif

#if defined(VIT_METHOD_WILLIAMS_MAX_STEIN)
float wms_fit(float u)
{
    return -1.26551223 + u * (1.00002368 + u * (0.37409196 + u * (0.09678418 + u * (-0.18628806 + u * (0.27886807 +
           u * (-1.13520398 + u * (1.48851587 + u * (-0.82215223 + u * 0.17087277))))))));
}

// Dawson's integral after Rybicki, x >= 0; beyond its reach 1/(2x).
float wms_dawson(float x)
{
    float small = x * (1.0 - (2.0 / 3.0) * x * x * (1.0 - 0.4 * x * x * (1.0 - (2.0 / 7.0) * x * x)));
    float n0 = 2.0 * floor(1.25 * min(x, 1e4) + 0.5), xp = min(x, 1e4) - 0.4 * n0;
    float e1 = exp(0.8 * xp), e2 = e1 * e1, up = n0 + 1.0, down = n0 - 1.0, sum = 0.0;
    // The weights e^-(0.4 (2i+1))^2 of the six terms; a loop would need an array, which ES 2 cannot fill.
#define TERM(weight) sum += weight * (e1 / up + 1.0 / (down * e1)); up += 2.0; down -= 2.0; e1 *= e2;
    TERM(0.852144) TERM(0.236928) TERM(0.0183156) TERM(0.000393669) TERM(2.35258e-6) TERM(3.90894e-9)
#undef TERM
    float wide = 0.5641895835 * exp(-xp * xp) * sum;
    return x <= 0.2 ? small : x > 1e4 ? 0.5 / x : wide;
}

float wms_psi(float a, float b)
{
    float difference = a - b;
    if (abs(difference) < 1e-4)
        return a > 0.0 ? (1.0 - exp(-a)) / a : 1.0;
    float scale = inversesqrt(2.0 * abs(difference)), front = b * scale, back = a * scale;
    if (difference > 0.0) {
        float u = 1.0 / (1.0 + 0.5 * front), v = 1.0 / (1.0 + 0.5 * back);
        return 1.7724538509 * scale *
               (u * exp(wms_fit(u)) - exp(front * front - back * back) * v * exp(wms_fit(v)));
    }
    return 2.0 * scale * (wms_dawson(front) - exp(back * back - front * front) * wms_dawson(back));
}
#endif

vec3 segment_light(vec3 behind, vec3 back, vec3 front, float value_back, float value_front, float D)
{
    vec3 mean = 0.5 * (back + front);
    float a = value_back * D, b = value_front * D;
#if defined(VIT_METHOD_RIEMANN) || defined(VIT_METHOD_RIEMANN_SLAB)
    vec3 light = behind;
    for (int i = 0; i < 16; i++) {
        float t = (float(i) + 0.5) / 16.0, depth = mix(a, b, t) / 16.0, zeta = exp(-depth);
#if defined(VIT_METHOD_RIEMANN_SLAB)
        light = light * zeta + mix(back, front, t) * (1.0 - zeta);
#else
        light = light * zeta + mix(back, front, t) * depth;
#endif
    }
    return light;
#elif defined(VIT_METHOD_AVERAGE)
    return even_light(behind, mean, exp(-0.5 * (a + b)));
#elif defined(VIT_METHOD_AVERAGE_OPACITY)
    return even_light(behind, mean, exp(-opacity_depth(0.5 * (value_back + value_front), D)));
#elif defined(VIT_METHOD_WILLIAMS_MAX_STEIN)
    return linear_light(behind, back, front, exp(-0.5 * (a + b)), wms_psi(a, b));
#elif defined(VIT_METHOD_PSI_TABLE)
    return linear_light(behind, back, front, exp(-0.5 * (a + b)), table_psi(a, b));
#elif defined(VIT_METHOD_LINEAR_AVERAGE_OPACITY)
    float depth = opacity_depth(0.5 * (value_back + value_front), D);
    return linear_light(behind, back, front, exp(-depth), even_psi(depth));
#elif defined(VIT_METHOD_MORELAND_CLOSE)
    float step = value_back - value_front;
    float opacity = min(0.5 * (value_back + value_front) + 0.108165 * step * step, 1.0);
    float psi = even_psi(opacity_depth(min(0.27 * value_back + 0.73 * value_front, 1.0), D));
    return linear_light(behind, back, front, exp(-opacity_depth(opacity, D)), psi);
#elif defined(VIT_METHOD_GAUSSIAN)
    float peak = max(1.0, max(value_back, value_front));
    float v1 = sqrt(-log(max(value_front / peak, 1e-12))), v2 = sqrt(-log(max(value_back / peak, 1e-12)));
    float d = v2 - v1;
    float integral = abs(d) > 1e-3 ? 0.886226925 / d * (erf_of(v2) - erf_of(v1)) : exp(-0.25 * (v1 + v2) * (v1 + v2));
    return even_light(behind, mean, exp(-peak * D * integral));
#elif defined(VIT_METHOD_ATTENUATION_ONLY)
    return behind * exp(-0.5 * (a + b));
#elif defined(VIT_METHOD_EMISSION_ONLY)
    return behind + (back * a + front * b) / 3.0 + (back * b + front * a) / 6.0;
#elif defined(VIT_METHOD_HOMOGENEOUS)
    return even_light(behind, front, exp(-b));
#elif defined(VIT_METHOD_PREINTEGRATED)
    vec4 entry = VIT_TEXTURE_2D(entries, (vec2(value_back, back.z) * (entries_size - 1.0) + 0.5) / entries_size);
    return behind * (1.0 - entry.a) + entry.rgb;
#else
#if defined(VIT_OPACITY)
    vec2 weights = vit_zeta_psi_opacity(value_back, value_front, D);
#else
    vec2 weights = vit_zeta_psi(a, b);
#endif
    return linear_light(behind, back, front, weights.x, weights.y);
#endif
}
