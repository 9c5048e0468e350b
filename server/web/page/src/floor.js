// A plane of the scene, drawn as a large square with lines that fade with the distance. From behind, from within the solid, it is
// hatched, as a solid is in a drawing of mechanics.

import {Color, DoubleSide, Mesh, PlaneGeometry, Quaternion, ShaderMaterial, Vector3} from 'three';

const VERTEX = `
varying vec2 place;
void main() {
  place = position.xy;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const FRAGMENT = `
uniform vec3 surface;
uniform vec3 line;
uniform float spacing;
uniform float reach;
uniform float hatch;
varying vec2 place;
float lines(float step) {
  vec2 at = place / step;
  vec2 width = fwidth(at);
  vec2 off = abs(fract(at - 0.5) - 0.5) / width;
  float shown = 1.0 - clamp(2.5 * max(width.x, width.y) - 0.25, 0.0, 1.0);
  return shown * (1.0 - min(min(off.x, off.y), 1.0));
}
void main() {
  float near = 1.0 - smoothstep(0.35 * reach, reach, length(place));
  float drawn = max(0.55 * lines(spacing), lines(5.0 * spacing));
  float opacity = mix(0.5, 0.9, drawn);
  if (!gl_FrontFacing) {
    float stripe = fract(dot(gl_FragCoord.xy, vec2(0.7071)) / hatch);
    float hatched = 1.0 - smoothstep(0.05, 0.1, min(stripe, 1.0 - stripe));
    drawn = max(0.6 * drawn, 0.7 * hatched);
    opacity = mix(0.6, 0.8, hatched);
  }
  gl_FragColor = vec4(mix(surface, line, drawn), near * opacity);
  #include <colorspace_fragment>
}`;

const HATCH = 16;  // [px] between two strokes

/**
 * @param {{point: number[], normal: number[]}} plane
 * @param {{center: Vector3, size: number}} frame what the camera looks at
 * @param {number} spacing [m] between two lines
 */
export function makeFloor(plane, frame, spacing) {
  const normal = new Vector3(...plane.normal).normalize();
  const reach = 3 * frame.size;
  const material = new ShaderMaterial({
    uniforms: {surface: {value: new Color()}, line: {value: new Color()}, spacing: {value: spacing}, reach: {value: reach}, hatch: {value: HATCH * Math.min(devicePixelRatio, 2)}},
    vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthWrite: false, side: DoubleSide,
  });
  const mesh = new Mesh(new PlaneGeometry(2 * reach, 2 * reach), material);
  mesh.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal));
  const offset = new Vector3(...plane.point).sub(frame.center).dot(normal);
  mesh.position.copy(frame.center).addScaledVector(normal, offset);
  mesh.renderOrder = 1;
  return mesh;
}
