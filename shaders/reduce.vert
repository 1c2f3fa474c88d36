// One triangle over the whole picture.
VIT_ATTRIBUTE vec3 outline;

void main()
{
    gl_Position = vec4(outline.xy, 0.0, 1.0);
}
