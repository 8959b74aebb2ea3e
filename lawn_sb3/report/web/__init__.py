"""Pages that need nothing but a browser: one HTML file each, with its data, styles and scripts inside."""
