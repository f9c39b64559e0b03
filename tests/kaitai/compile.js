// Compiles a Kaitai Struct schema: node compile.js SCHEMA FOLDER LANGUAGE ...
'use strict';
const fs = require('fs');
const path = require('path');
const yaml = require('js-yaml');
const compiler = require('kaitai-struct-compiler');

async function main() {
  const [schema, folder, ...languages] = process.argv.slice(2);
  const parsed = yaml.load(fs.readFileSync(schema, 'utf8'));
  for (const language of languages) {
    const files = await compiler.compile(language, parsed, null, false);
    for (const [name, text] of Object.entries(files)) fs.writeFileSync(path.join(folder, name), text);
  }
}

main().catch((error) => {
  console.error(String(error));
  process.exit(1);
});
