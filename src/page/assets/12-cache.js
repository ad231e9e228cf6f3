// LRU cache of decoded frames.
class FrameCache {
  constructor(bytes) {
    this.room = bytes;
    this.used = 0;
    this.frames = new Map(); // id to { promise, frame, bytes }
  }

  has(id) {
    const entry = this.frames.get(id);
    return entry !== undefined && entry.frame !== null;
  }

  // The decoded frame, or undefined.
  get(id) {
    const entry = this.frames.get(id);
    return entry && entry.frame || undefined;
  }

  load(id) {
    let entry = this.frames.get(id);
    if (entry) { // move to the end: most recently used
      this.frames.delete(id);
      this.frames.set(id, entry);
      return entry.promise;
    }
    entry = { promise: null, frame: null, bytes: 0 };
    entry.promise = decodeFrame(id).then(frame => {
      entry.frame = frame;
      entry.bytes = 4 * frame.bitmap.width * frame.bitmap.height;
      this.used += entry.bytes;
      this.trim(id);
      return frame;
    });
    this.frames.set(id, entry);
    return entry.promise;
  }

  trim(keep) {
    for (const [id, entry] of this.frames) {
      if (this.used <= this.room)
        return;
      if (id === keep || entry.frame === null)
        continue;
      this.frames.delete(id);
      this.used -= entry.bytes;
      entry.frame.bitmap.close();
    }
  }
}
