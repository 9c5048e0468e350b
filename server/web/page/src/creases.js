// Normals for a mesh without any: round where its faces meet at a small angle, sharp where they meet at a large one.

const SAME = 0.9999;  // cosine of an angle between normals that nobody sees
const CREASE = Math.cos((35 * Math.PI) / 180);

/**
 * @param {Float32Array} positions three a vertex
 * @param {Uint32Array} corners three vertices a triangle
 * @returns {{positions: Float32Array, normals: Float32Array, corners: Uint32Array}} a vertex on a crease stands in it several times
 */
export function withNormals(positions, corners) {
  const faces = faceNormals(positions, corners);
  const {begin, around} = facesAround(positions.length / 3, corners);
  const made = new Int32Array(positions.length / 3).fill(-1);  // for each vertex the last of its copies
  const before = [];  // for each copy the one before it
  const [places, normals] = [[], []];
  const result = new Uint32Array(corners.length);
  for (let corner = 0; corner < corners.length; ++corner) {
    const own = 3 * Math.floor(corner / 3);
    const vertex = corners[corner];
    let [x, y, z] = [0, 0, 0];
    for (let i = begin[vertex]; i < begin[vertex + 1]; ++i) {
      const other = 3 * around[i];
      if (cosine(faces, own, other) < CREASE) continue;
      x += faces[other];
      y += faces[other + 1];
      z += faces[other + 2];
    }
    const length = Math.hypot(x, y, z) || 1;
    [x, y, z] = [x / length, y / length, z / length];
    let copy = made[vertex];
    while (copy >= 0 && normals[3 * copy] * x + normals[3 * copy + 1] * y + normals[3 * copy + 2] * z < SAME) copy = before[copy];
    if (copy < 0) {
      copy = before.length;
      before.push(made[vertex]);
      made[vertex] = copy;
      normals.push(x, y, z);
      places.push(positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2]);
    }
    result[corner] = copy;
  }
  return {positions: new Float32Array(places), normals: new Float32Array(normals), corners: result};
}

/** Normals of the faces, each as long as twice the face's area, so that large faces count for more. */
function faceNormals(positions, corners) {
  const normals = new Float32Array(corners.length);
  for (let i = 0; i < corners.length; i += 3) {
    const [a, b, c] = [3 * corners[i], 3 * corners[i + 1], 3 * corners[i + 2]];
    const [ux, uy, uz] = [positions[b] - positions[a], positions[b + 1] - positions[a + 1], positions[b + 2] - positions[a + 2]];
    const [vx, vy, vz] = [positions[c] - positions[a], positions[c + 1] - positions[a + 1], positions[c + 2] - positions[a + 2]];
    normals[i] = uy * vz - uz * vy;
    normals[i + 1] = uz * vx - ux * vz;
    normals[i + 2] = ux * vy - uy * vx;
  }
  return normals;
}

/** For each vertex the faces that meet there: around[begin[v]] .. around[begin[v + 1]]. */
function facesAround(vertices, corners) {
  const begin = new Uint32Array(vertices + 2);
  for (const vertex of corners) begin[vertex + 2] += 1;
  for (let i = 2; i < begin.length; ++i) begin[i] += begin[i - 1];
  const around = new Uint32Array(corners.length);
  for (let i = 0; i < corners.length; ++i) around[begin[corners[i] + 1]++] = Math.floor(i / 3);
  return {begin, around};
}

function cosine(faces, i, j) {
  if (i === j) return 1;
  const dot = faces[i] * faces[j] + faces[i + 1] * faces[j + 1] + faces[i + 2] * faces[j + 2];
  const lengths = Math.hypot(faces[i], faces[i + 1], faces[i + 2]) * Math.hypot(faces[j], faces[j + 1], faces[j + 2]);
  return lengths > 0 ? dot / lengths : -1;
}
