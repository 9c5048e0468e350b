// Many copies of one shape in one draw call.

import {Color, DynamicDrawUsage, InstancedBufferAttribute, InstancedMesh, Matrix4, Quaternion, Vector3} from 'three';

const matrix = new Matrix4();
const color = new Color();
const up = new Vector3(0, 0, 1);
const turn = new Quaternion();
const size = new Vector3();
const direction = new Vector3();

/** Copies that are written anew for every picture: clear(), add...(), done(). */
export class Pool {
  /**
   * @param {import('three').BufferGeometry} geometry
   * @param {import('three').Material} material
   * @param {import('three').Object3D} parent
   * @param {number} renderOrder
   */
  constructor(geometry, material, parent, renderOrder = 0) {
    this.geometry = geometry;
    this.material = material;
    this.parent = parent;
    this.renderOrder = renderOrder;
    this.count = 0;
    this.tinted = false;  // whether a copy has a colour of its own
    this.#grow(16);
  }

  clear() {
    this.count = 0;
  }

  /** @param {Vector3} position @param {Quaternion} quaternion @param {Vector3} scale @param {string} [tint] */
  add(position, quaternion, scale, tint) {
    if (this.count === this.mesh.instanceMatrix.count) this.#grow(2 * this.count);
    this.mesh.setMatrixAt(this.count, matrix.compose(position, quaternion, scale));
    if (tint) {
      this.mesh.setColorAt(this.count, color.set(tint));
      this.tinted = true;
    }
    this.count += 1;
  }

  /** A copy whose z axis becomes `along`, as long as that, and as thick as `width`. */
  addAlong(position, along, width) {
    const length = along.length();
    if (length < 1e-9) return;
    turn.setFromUnitVectors(up, direction.copy(along).divideScalar(length));
    this.add(position, turn, size.set(width, width, length));
  }

  done() {
    this.mesh.count = this.count;
    this.mesh.visible = this.count > 0;  // Else it costs a draw call.
    for (const attribute of this.tinted ? [this.mesh.instanceMatrix, this.mesh.instanceColor] : [this.mesh.instanceMatrix]) {
      if (this.count === 0) continue;
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, attribute.itemSize * this.count);
      attribute.needsUpdate = true;
    }
  }

  #grow(capacity) {
    const mesh = new InstancedMesh(this.geometry, this.material, capacity);
    mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    // White: so all pools have the same shader, with or without colours of the copies.
    mesh.instanceColor = new InstancedBufferAttribute(new Float32Array(3 * capacity).fill(1), 3).setUsage(DynamicDrawUsage);
    mesh.frustumCulled = false;
    mesh.renderOrder = this.renderOrder;
    mesh.count = this.count;  // None is drawn before done().
    if (this.mesh) {
      for (let i = 0; i < this.count; ++i) {
        this.mesh.getMatrixAt(i, matrix);
        mesh.setMatrixAt(i, matrix);
        this.mesh.getColorAt(i, color);
        mesh.setColorAt(i, color);
      }
      this.parent.remove(this.mesh);
      this.mesh.dispose();
    }
    this.mesh = mesh;
    this.parent.add(mesh);
  }
}
