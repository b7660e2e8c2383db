// The OpenAPI document of the API as a table.

const schema = await (await fetch("/openapi.json")).json();

function cell(tag, text) {
  const made = document.createElement(tag);
  made.textContent = text;
  return made;
}

function sent(operation) {
  const body = operation.requestBody?.content["application/json"].schema.$ref;
  if (!body) return "";
  return Object.keys(schema.components.schemas[body.split("/").pop()].properties).join(", ");
}

document.getElementById("about").textContent = schema.info.description;
document.getElementById("rows").append(...Object.entries(schema.paths).flatMap(([path, methods]) =>
  Object.entries(methods).map(([method, operation]) => {
    const row = document.createElement("tr");
    row.append(
      cell("td", `${method.toUpperCase()} ${path}`),
      cell("td", operation.description || ""),
      cell("td", sent(operation)),
    );
    return row;
  })));
