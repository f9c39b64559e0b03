// Reads .bdt files with the reader that bdt.ksy gives in JavaScript: node dump.js FOLDER FILE ...
//
// FOLDER holds the generated reader. Prints one line of JSON per file: {"fields": …}, or {"refused": …} for a file that
// the reader does not take. Names are in lower case without underscores, since languages differ in them; numbers are the
// sixteen digits of an f64, bytes an `x` and hexadecimal digits. dump.py prints the same from the reader in Python.
'use strict';
const fs = require('fs');
const path = require('path');
const stream = require('kaitai-struct');

const [folder, ...files] = process.argv.slice(2);
const KaitaiStream = stream.KaitaiStream || stream;
const loaded = require(path.resolve(folder, 'Bdt.js'));
const Bdt = loaded.Bdt || loaded;

const scratch = Buffer.alloc(8);

function hexadecimal(bytes) {
  return Buffer.from(bytes).toString('hex');
}

// Fields and computed values of a record. A computed value that is a record stands elsewhere in the file already.
function names(object) {
  const own = Object.keys(object);
  const prototype = Object.getPrototypeOf(object);
  const computed = Object.getOwnPropertyNames(prototype).filter(
    (name) => Object.getOwnPropertyDescriptor(prototype, name).get);
  return [own, computed].map((some) => some.filter((name) => !name.startsWith('_') && !name.startsWith('check')));
}

function isRecord(value) {
  return typeof value === 'object' && value !== null && '_io' in value;
}

function dump(value) {
  if (Array.isArray(value)) return value.map(dump);
  if (typeof value === 'number') {
    scratch.writeDoubleBE(value);
    return scratch.toString('hex');
  }
  if (value instanceof Uint8Array) return 'x' + hexadecimal(value);
  if (!isRecord(value)) return value;
  const fields = {};
  const [own, computed] = names(value);
  const put = (name) => {
    const field = value[name];
    if (field !== undefined) fields[name.toLowerCase()] = dump(field);
  };
  own.forEach(put);
  computed.filter((name) => !isRecord(value[name])).forEach(put);
  return fields;
}

for (const file of files) {
  let line;
  try {
    line = {fields: dump(new Bdt(new KaitaiStream(fs.readFileSync(file))))};
  } catch (error) {
    line = {refused: String(error)};
  }
  process.stdout.write(JSON.stringify(line) + '\n');
}
