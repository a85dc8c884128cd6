"""Charts as SVG text, coloured by the page's custom properties, so that they follow light and dark."""
